#include "common/config/loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/config/test_configs.h"
#include "common/config/writer.h"
#include "common/core/random.h"

namespace gw {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr char kGood[] = R"(robot:
  name: test
calibration:
  camera:
    kind: stereo
    width: 640
    height: 480
    rate_hz: 30
    left: {fx: 385, fy: 385, cx: 320, cy: 240}
    right: {fx: 385, fy: 385, cx: 320, cy: 240}
    T_C0C1: {p: [0.05, 0, 0], q_wxyz: [1, 0, 0, 0]}
    T_BC:
      p: [0.1, 0, 0.25]
      q_wxyz: [0.5, -0.5, 0.5, -0.5]
  imu:
    present: true
  wheel:
    present: false
frontend:
  variant: full
  min_inliers: 15
  orb: {fast_threshold: 20, num_features: 900}
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string MessageFor(const std::string& text) {
  const auto result = ParseRobotConfig(text, "f.yaml");
  if (result.ok()) return "(loaded)";
  EXPECT_EQ(result.error().code, ErrorCode::kBadConfig);
  return result.error().message;
}

TEST(Loader, ReadsEveryKindOfField) {
  const auto config = ParseRobotConfig(kGood, "f.yaml");
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->robot.name, "test");
  EXPECT_EQ(config->calibration.camera.kind, CameraKind::kStereo);
  EXPECT_EQ(config->calibration.camera.left.fx, 385.0);
  EXPECT_EQ(config->calibration.camera.T_BC.translation(), Eigen::Vector3d(0.1, 0, 0.25));
  EXPECT_EQ(config->calibration.camera.T_BC.rotation().w(), 0.5);
  EXPECT_EQ(config->calibration.camera.T_BC.rotation().x(), -0.5);
  EXPECT_TRUE(config->calibration.imu.present);
  EXPECT_EQ(config->frontend.min_inliers, 15);
  EXPECT_EQ(config->frontend.orb.num_features, 900);
  EXPECT_EQ(config->frontend.orb.num_levels, OrbConfig{}.num_levels);
}

struct BadCase {
  const char* name;
  const char* from;
  const char* to;
  const char* message;
};

class LoaderRefuses : public testing::TestWithParam<BadCase> {};

TEST_P(LoaderRefuses, AndSaysWhereAndWhy) {
  const BadCase& c = GetParam();
  EXPECT_EQ(MessageFor(Replaced(kGood, c.from, c.to)), c.message);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, LoaderRefuses,
    testing::Values(
        BadCase{"UnknownKey", "min_inliers: 15", "colour: 15",
                "f.yaml:21: frontend.colour: no such key, remove it"},
        BadCase{"MisspelledKey", "min_inliers: 15", "min_inlier: 15",
                "f.yaml:21: frontend.min_inlier: no such key, did you mean `min_inliers`?"},
        BadCase{"UnknownSection", "frontend:", "frontend2: {}\nfrontend:",
                "f.yaml:19: frontend2: no such key, did you mean `frontend`?"},
        BadCase{"MissingKey", "    width: 640\n", "",
                "f.yaml:4: calibration.camera.width: missing, add it: image width (px)"},
        BadCase{"MissingSection", "robot:\n  name: test\n", "",
                "f.yaml:1: robot: missing, add it: who this is"},
        BadCase{"MissingKeyOfEmptySection", "  name: test\n", "",
                "f.yaml:1: robot.name: missing, add it: of the robot or recording; appears in "
                "reports"},
        BadCase{"MissingPartOfPose", "      p: [0.1, 0, 0.25]\n", "",
                "f.yaml:12: calibration.camera.T_BC.p: missing, add it: x, y, z (m)"},
        BadCase{
            "DuplicateKey", "min_inliers: 15", "min_inliers: 15\n  min_inliers: 16",
            "f.yaml:22: frontend.min_inliers = 16: duplicate key, first in line 21, remove one"},
        BadCase{"BoolForInt", "min_inliers: 15", "min_inliers: true",
                "f.yaml:21: frontend.min_inliers = true: must be an int, write digits without "
                "point, exponent or quotes"},
        BadCase{"FloatForInt", "min_inliers: 15", "min_inliers: 15.0",
                "f.yaml:21: frontend.min_inliers = 15.0: must be an int, write digits without "
                "point, exponent or quotes"},
        BadCase{"HexForInt", "min_inliers: 15", "min_inliers: 0x0F",
                "f.yaml:21: frontend.min_inliers = 0x0F: must be an int, write digits without "
                "point, exponent or quotes"},
        BadCase{"TextForInt", "min_inliers: 15", "min_inliers: \"15\"",
                "f.yaml:21: frontend.min_inliers = \"15\": must be an int, write digits without "
                "point, exponent or quotes"},
        BadCase{"HugeInt", "min_inliers: 15", "min_inliers: 99999999999",
                "f.yaml:21: frontend.min_inliers = 99999999999: out of range, must be 6 to 500 "
                "count"},
        BadCase{"IntForBool", "present: true", "present: 1",
                "f.yaml:16: calibration.imu.present = 1: must be a bool, write true or false"},
        BadCase{"YesForBool", "present: true", "present: yes",
                "f.yaml:16: calibration.imu.present = yes: must be a bool, write true or false"},
        BadCase{"BoolForFloat", "rate_hz: 30", "rate_hz: true",
                "f.yaml:8: calibration.camera.rate_hz = true: must be a finite number, write it "
                "without quotes"},
        BadCase{"NaN", "rate_hz: 30", "rate_hz: .nan",
                "f.yaml:8: calibration.camera.rate_hz = .nan: must be a finite number, write it "
                "without quotes"},
        BadCase{"PlainNaN", "rate_hz: 30", "rate_hz: nan",
                "f.yaml:8: calibration.camera.rate_hz = nan: must be a finite number, write it "
                "without quotes"},
        BadCase{"Overflow", "rate_hz: 30", "rate_hz: 1e999",
                "f.yaml:8: calibration.camera.rate_hz = 1e999: must be a finite number, write it "
                "without quotes"},
        BadCase{"NoValue", "rate_hz: 30", "rate_hz:",
                "f.yaml:8: calibration.camera.rate_hz = (nothing): must be a finite number, write "
                "it without quotes"},
        BadCase{"BelowRange", "fx: 385", "fx: -385",
                "f.yaml:9: calibration.camera.left.fx = -385: out of range, must be 1 to 100000 "
                "px"},
        BadCase{"AboveRange", "rate_hz: 30", "rate_hz: 1e6",
                "f.yaml:8: calibration.camera.rate_hz = 1e6: out of range, must be 1 to 200 Hz"},
        BadCase{"NumberForText", "name: test", "name: 17",
                "f.yaml:2: robot.name = 17: must be text, put it in quotes"},
        BadCase{"EmptyText", "name: test", "name: \"\"",
                "f.yaml:2: robot.name = \"\": must not be empty"},
        BadCase{"ListForText", "name: test", "name: [a, b]",
                "f.yaml:2: robot.name = [...]: must be text"},
        BadCase{"BadEnum", "kind: stereo", "kind: mono",
                "f.yaml:5: calibration.camera.kind = mono: no such choice, write stereo or rgbd"},
        BadCase{"BadEnumOfMany", "variant: full", "variant: 3",
                "f.yaml:20: frontend.variant = 3: no such choice, write none, da, pe, lba, full, "
                "fixed or switch"},
        BadCase{"ScalarForSection", "  wheel:\n    present: false", "  wheel: false",
                "f.yaml:17: calibration.wheel = false: must be a section, write `key: value` "
                "lines"},
        BadCase{"ScalarForPose", "T_C0C1: {p: [0.05, 0, 0], q_wxyz: [1, 0, 0, 0]}", "T_C0C1: 0.05",
                "f.yaml:11: calibration.camera.T_C0C1 = 0.05: must be a pose, write {p: [x, y, z], "
                "q_wxyz: [w, x, y, z]}"},
        BadCase{"ShortList", "p: [0.1, 0, 0.25]", "p: [0.1, 0]",
                "f.yaml:13: calibration.camera.T_BC.p = [...]: must be a list of 3 numbers, has 2"},
        BadCase{"ScalarForList", "p: [0.1, 0, 0.25]", "p: 0.1",
                "f.yaml:13: calibration.camera.T_BC.p = 0.1: must be a list of 3 numbers"},
        BadCase{"BadElement", "p: [0.1, 0, 0.25]", "p: [0.1,\n         up, 0.25]",
                "f.yaml:14: calibration.camera.T_BC.p[1] = up: must be a finite number, write it "
                "without quotes"},
        BadCase{"QuaternionNotUnit", "q_wxyz: [0.5, -0.5, 0.5, -0.5]",
                "q_wxyz: [0.5, -0.5, 0.5, -0.6]",
                "f.yaml:14: calibration.camera.T_BC.q_wxyz: norm is 1.0535653752852738, must be 1 "
                "(+-0.001); order is w, x, y, z"},
        BadCase{"ZeroQuaternion", "q_wxyz: [0.5, -0.5, 0.5, -0.5]", "q_wxyz: [0, 0, 0, 0]",
                "f.yaml:14: calibration.camera.T_BC.q_wxyz: norm is 0, must be 1 (+-0.001); order "
                "is w, x, y, z"},
        BadCase{"UnknownKeyOfPose", "      p: [0.1, 0, 0.25]",
                "      p: [0.1, 0, 0.25]\n      rpy: 0",
                "f.yaml:14: calibration.camera.T_BC.rpy: no such key, remove it"},
        BadCase{"StereoWithoutRightEye", "    right: {fx: 385, fy: 385, cx: 320, cy: 240}\n", "",
                "f.yaml:4: calibration.camera.right: missing, kind: stereo needs both eyes"},
        BadCase{"StereoWithoutBaseline", "    T_C0C1: {p: [0.05, 0, 0], q_wxyz: [1, 0, 0, 0]}\n",
                "",
                "f.yaml:4: calibration.camera.T_C0C1: missing, kind: stereo needs the right "
                "camera's pose in the left's frame"},
        BadCase{"SwappedEyes", "p: [0.05, 0, 0]", "p: [-0.05, 0, 0]",
                "f.yaml:11: calibration.camera.T_C0C1: the right camera is not to the right (+x) "
                "of the left; are the eyes swapped?"},
        BadCase{"PrincipalPointOutside", "width: 640", "width: 320",
                "f.yaml:9: calibration.camera.left: principal point lies outside the image; check "
                "cx, cy, width, height"},
        BadCase{"DepthRangeEmpty", "    T_BC:", "    depth_min_m: 8\n    T_BC:",
                "f.yaml:12: calibration.camera.depth_min_m = 8: must be smaller than depth_max_m"},
        BadCase{"AlphaBoundsSwapped", "min_inliers: 15", "dr_weight: {alpha_max: 0.01}",
                "f.yaml:21: frontend.dr_weight.alpha_max = 0.01: must not be smaller than "
                "alpha_min (0.1); dead reckoning counts more when tracking is worse"},
        BadCase{"FastThresholdsSwapped", "fast_threshold: 20", "fast_threshold: 5",
                "f.yaml:22: frontend.orb.fast_threshold_low: must not be larger than "
                "fast_threshold (5); lower it or raise fast_threshold"},
        BadCase{"KeyIsAList", "min_inliers: 15", "[a, b]: 15",
                "f.yaml:21: frontend: a key must be one word"},
        BadCase{"SecondDocument", "frontend:", "---\nfrontend:",
                "f.yaml:20: a second document starts here, one file is one robot"}),
    [](const auto& test_case) { return test_case.param.name; });

TEST(Loader, ReportsAllMistakesAtOnceInTheOrderOfTheFile) {
  std::string text = Replaced(kGood, "width: 640", "widht: 640");
  text = Replaced(text, "rate_hz: 30", "rate_hz: fast");
  text = Replaced(text, "fast_threshold: 20", "fast_threshold: 5");
  text = Replaced(text, "name: test", "name: true");
  EXPECT_EQ(MessageFor(text),
            "f.yaml:2: robot.name = true: must be text, put it in quotes\n"
            "f.yaml:4: calibration.camera.width: missing, add it: image width (px)\n"
            "f.yaml:6: calibration.camera.widht: no such key, did you mean `width`?\n"
            "f.yaml:8: calibration.camera.rate_hz = fast: must be a finite number, write it "
            "without quotes\n"
            "f.yaml:22: frontend.orb.fast_threshold_low: must not be larger than fast_threshold "
            "(5); lower it or raise fast_threshold");
}

TEST(Loader, NormalisesAQuaternionThatIsNearlyUnit) {
  const auto config = ParseRobotConfig(
      Replaced(kGood, "[0.5, -0.5, 0.5, -0.5]", "[0.5003, -0.5003, 0.5003, -0.5003]"), "f.yaml");
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_NEAR(config->calibration.camera.T_BC.rotation().w(), 0.5, 1e-15);
}

TEST(Loader, SectionWithAllKeysCommentedOutMeansDefaults) {
  EXPECT_TRUE(
      ParseRobotConfig(std::string(kGood) + "backend:\n  # local_keyframes: 10\n", "f").ok());
}

TEST(Loader, EmptyFileAndBadYamlAreClear) {
  EXPECT_EQ(MessageFor(""), "f.yaml:1: file is empty, start from a file in config/robots");
  EXPECT_EQ(MessageFor("# only this\n"),
            "f.yaml:1: file is empty, start from a file in config/robots");
  EXPECT_THAT(MessageFor("just words"),
              HasSubstr("f.yaml:1: file = just words: must be a section"));
  EXPECT_THAT(MessageFor("robot:\n\tname: x\n"), StartsWith("f.yaml:2: not valid YAML: "));
  EXPECT_THAT(MessageFor("robot: {name: x\n"), StartsWith("f.yaml:2: not valid YAML: "));
  EXPECT_THAT(MessageFor("robot: *nobody\n"), StartsWith("f.yaml:1: not valid YAML: "));
}

TEST(Loader, FileThatCannotBeReadIsNamed) {
  const auto missing = LoadRobotConfig("no/such/robot.yaml");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, StartsWith("no/such/robot.yaml: cannot open"));
  const auto directory = LoadRobotConfig(GW_SOURCE_DIR);
  ASSERT_FALSE(directory.ok());
  EXPECT_EQ(directory.error().code, ErrorCode::kIo);
}

// Whatever a damaged file holds, the loader answers by value.
TEST(Loader, DamagedFilesNeverThrow) {
  const std::string good = WriteRobotConfig(StereoRobotForTest());
  for (int i = 0; i < 1000; ++i) {
    CounterRng rng(3, 0, i);
    std::string text = good;
    for (uint32_t edits = 1 + rng.Below(4); edits > 0; --edits) {
      const size_t at = rng.Below(static_cast<uint32_t>(text.size()));
      switch (rng.Below(3)) {
        case 0:
          text[at] = static_cast<char>(rng.Below(256));
          break;
        case 1:
          text.erase(at, rng.Below(40));
          break;
        default:
          text.insert(at, std::string(1, "{}[]:,&*#|>-?!%@\n\t \"'"[rng.Below(21)]));
      }
      if (text.empty()) break;
    }
    const auto result = ParseRobotConfig(text, "damaged.yaml");
    if (!result.ok()) {
      EXPECT_FALSE(result.error().message.empty()) << "case " << i;
    }
  }
  std::string deep(20000, '[');
  EXPECT_FALSE(ParseRobotConfig(deep, "deep.yaml").ok());
}

TEST(RobotFiles, EveryFileInConfigRobotsLoads) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GW_SOURCE_DIR "/config/robots")) {
    if (entry.path().extension() != ".yaml") continue;
    const auto config = LoadRobotConfig(entry.path().string());
    EXPECT_TRUE(config.ok()) << config.error().message;
    ++files;
  }
  EXPECT_GT(files, 0);
}

}  // namespace
}  // namespace gw

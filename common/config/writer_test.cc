#include "common/config/writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/config/loader.h"
#include "common/config/test_configs.h"
#include "common/core/random.h"

namespace gw {
namespace {

using testing::HasSubstr;
using testing::Not;

RobotConfig Reload(const std::string& text) {
  const auto loaded = ParseRobotConfig(text, "written.yaml");
  EXPECT_TRUE(loaded.ok()) << loaded.error().message << "\n" << text;
  return loaded.ok() ? *loaded : RobotConfig{};
}

TEST(Writer, EffectiveTextReadsBackToTheSameValues) {
  const RobotConfig config = StereoRobotForTest();
  const RobotConfig reloaded = Reload(WriteRobotConfig(config));
  EXPECT_EQ(WriteRobotConfig(reloaded), WriteRobotConfig(config));
  EXPECT_EQ(ConfigHash(reloaded), ConfigHash(config));
  EXPECT_EQ(reloaded.robot.name, config.robot.name);
  EXPECT_EQ(reloaded.calibration.camera.right.fx, config.calibration.camera.right.fx);
  EXPECT_EQ(reloaded.calibration.camera.left.radtan, config.calibration.camera.left.radtan);
  EXPECT_EQ(reloaded.calibration.wheel.time_offset_s, config.calibration.wheel.time_offset_s);
  EXPECT_EQ(reloaded.frontend.variant, config.frontend.variant);
  EXPECT_EQ(reloaded.calibration.camera.T_BC.translation(),
            config.calibration.camera.T_BC.translation());
}

TEST(Writer, ShortTextReadsBackToTheSameValuesAndLeavesDefaultsOut) {
  const RobotConfig config = StereoRobotForTest();
  const std::string text = WriteRobotConfig(config, ConfigText::kShort);
  EXPECT_EQ(ConfigHash(Reload(text)), ConfigHash(config));
  EXPECT_THAT(text, HasSubstr("num_features: 1200"));
  EXPECT_THAT(text, Not(HasSubstr("num_levels")));
  EXPECT_THAT(text, HasSubstr("present: false"));  // wheel: required, though equal to its default
  EXPECT_LT(text.size(), WriteRobotConfig(config).size());
}

TEST(Writer, RgbdRobotHasNoRightEye) {
  RobotConfig config = StereoRobotForTest();
  config.calibration.camera.kind = CameraKind::kRgbd;
  config.calibration.camera.right = {};
  const std::string text = WriteRobotConfig(config);
  EXPECT_THAT(text, Not(HasSubstr("right:")));
  EXPECT_EQ(ConfigHash(Reload(text)), ConfigHash(config));
}

// The hash would otherwise differ between the program that wrote a file and the one that reads it.
TEST(Writer, AnyPoseSurvivesWritingAndReading) {
  for (int i = 0; i < 1000; ++i) {
    CounterRng rng(7, 0, i);
    RobotConfig config = StereoRobotForTest();
    const Eigen::Quaterniond q(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
    config.calibration.camera.T_BC =
        SE3(q, {rng.Normal(), rng.Normal() * 1e-9, rng.Normal() * 1e9});
    const RobotConfig reloaded = Reload(WriteRobotConfig(config));
    const SE3& T = reloaded.calibration.camera.T_BC;
    ASSERT_EQ(T.rotation().coeffs(), config.calibration.camera.T_BC.rotation().coeffs());
    ASSERT_EQ(T.translation(), config.calibration.camera.T_BC.translation());
    ASSERT_EQ(ConfigHash(reloaded), ConfigHash(config)) << "case " << i;
  }
}

TEST(ConfigHash, ChangesWithAnyValue) {
  const RobotConfig config = StereoRobotForTest();
  RobotConfig other = config;
  other.frontend.dr_weight.alpha_min = std::nextafter(other.frontend.dr_weight.alpha_min, 1.0);
  EXPECT_NE(ConfigHash(other), ConfigHash(config));
}

}  // namespace
}  // namespace gw

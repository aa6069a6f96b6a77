#include "tools/lab/study/fault_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "common/wire/channels.h"
#include "tools/lab/study/fault_cases.h"
#include "tools/lab/study/fault_measures.h"

namespace gw::study {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kBegin = 7'000'000;
constexpr int kWidth = 320, kHeight = 240;

// A robot with wheels alone on a circle of 2 m, for 10 s at 0.5 m/s; its camera sees nothing.
class FaultRunTest : public testing::Test {
 protected:
  FaultRunTest() {
    std::string name = (fs::temp_directory_path() / "gw_fault_run_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
    experiment_.path = (folder_ / "log.lcm").string();
    Calibration& calibration = experiment_.config.calibration;
    calibration.camera.kind = CameraKind::kRgbd;
    calibration.camera.width = kWidth;
    calibration.camera.height = kHeight;
    calibration.camera.rate_hz = 10;
    calibration.camera.left = {.fx = 200, .fy = 200, .cx = 160, .cy = 120};
    calibration.camera.T_BC = SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.3});
    calibration.wheel.present = true;
    WriteLog();
  }
  ~FaultRunTest() override { fs::remove_all(folder_); }

  fault::FaultPlan Plan(const std::string& name) const {
    const auto cases = FaultCases(FaultMatrix::kDr, experiment_.config, Milliseconds(10000));
    const auto chosen = ChooseCases(cases, {name});
    EXPECT_TRUE(chosen);
    return chosen->front().plan;
  }
  double ErrorOfWheels(const fault::FaultPlan& plan) const {
    const auto dr = ReckonWithFault(experiment_, experiment_.config, plan);
    EXPECT_TRUE(dr);
    EXPECT_GT(dr->filter.size(), 400u);
    return Ape(experiment_.truth, dr->wheels, eval::Alignment::kSe3).value_or(NAN);
  }

  Experiment experiment_;

 private:
  static SE3 PoseAt(double t) {
    const double angle = 0.25 * t;
    return SE3(ExpSO3({0, 0, angle}), {2 * std::sin(angle), 2 - 2 * std::cos(angle), 0});
  }
  void WriteLog() {
    auto log = process::EventLogWriter::Create(experiment_.path);
    ASSERT_TRUE(log);
    const std::vector<uint8_t> grey(kWidth * kHeight, 100), depth(2 * kWidth * kHeight, 4);
    for (int i = 1; i <= 500; ++i) {
      const double t = 0.02 * i;
      WheelSample wheel;
      wheel.utime = {kBegin + i * 20000};
      wheel.utime_begin = wheel.utime - Milliseconds(20);
      wheel.seq = i;
      const SE3 T = PoseAt(t - 0.02).inverse() * PoseAt(t);
      wheel.dx_m = T.translation().x();
      wheel.dy_m = T.translation().y();
      wheel.dyaw_rad = LogSO3(T.rotation()).z();
      ASSERT_TRUE(log->Append(wheel.utime, wire::kWheel, wire::Encode(wheel)));
      experiment_.truth.push_back({wheel.utime, PoseAt(t)});
      if (i % 5 != 0) continue;
      CameraFrame frame;
      frame.utime = wheel.utime;
      frame.seq = i / 5;
      frame.left = {grey.data(), kWidth, kHeight, kWidth, PixelFormat::kGray8};
      frame.depth = {depth.data(), kWidth, kHeight, 2 * kWidth, PixelFormat::kDepth16};
      ASSERT_TRUE(log->Append(frame.utime, wire::kCamera, wire::Encode(frame)));
    }
    ASSERT_TRUE(log->Close());
  }

  fs::path folder_;
};

TEST_F(FaultRunTest, TheWheelsOwnSumHasTheFault) {
  EXPECT_LT(ErrorOfWheels({}), 1e-3);
  EXPECT_GT(ErrorOfWheels(Plan("wheels_x2")), 0.5);
  // Half of the poses are 5 m beside the others, which alignment shares out.
  EXPECT_NEAR(ErrorOfWheels(Plan("wheels_jump")), 2, 0.6);
}

TEST_F(FaultRunTest, TheSystemRunsAndSaysWhatIsWrong) {
  const auto run = RunWithFault(&experiment_, experiment_.config, {}, 0);
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_EQ(run->run.frames.size(), 100u);
  ASSERT_TRUE(run->findings.contains("no_map"));
  EXPECT_EQ(run->findings.at("no_map").count, 100);
  EXPECT_EQ(run->findings.at("no_map").accused, Accused::kVision);
  EXPECT_TRUE(run->findings.at("no_map").in_health);  // no map can be begun
  const auto later = RunWithFault(&experiment_, experiment_.config, Plan("wheels_x2"), 2);
  ASSERT_TRUE(later);
  EXPECT_EQ(later->run.frames.size(), 94u);  // a seed drops three images
}

}  // namespace
}  // namespace gw::study

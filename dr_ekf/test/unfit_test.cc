// A stream that is found unfit takes with it what it has told: from then on the filter is the one
// that never had it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dr_ekf/core/noise_model.h"
#include "dr_ekf/core/without_accelerometer.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

constexpr double kTurnCentre = -0.15;  // m: an IMU that is not where the calibration says

struct Drive {
  std::vector<DrState> states;
  size_t unfit_at = 0;  // state at which the accelerometer was found unfit; 0: it was not
  int64_t rejected = 0;
};

Drive Reckon(const Recording& recording, bool accelerometer) {
  Calibration calibration = recording.calibration;
  calibration.imu.has_accel = accelerometer;
  DrFilter filter = std::move(DrFilter::Create({}, calibration)).value();
  Drive drive;
  for (const Sample& sample : recording.samples) {
    const DrFilter::Output out = Feed(filter, sample);
    const bool found = std::count(out.found.begin(), out.found.end(), DrDiagnosis::kAccelUnfit) > 0;
    if (found) drive.unfit_at = drive.states.size();
    drive.states.insert(drive.states.end(), out.states.begin(), out.states.end());
    drive.rejected = out.counters.rejected_late;
  }
  return drive;
}

Eigen::Vector3d Up(const DrState& state) {
  return state.T_OB.rotation() * Eigen::Vector3d::UnitZ();
}

Recording Unfit(uint64_t seed) {
  SimOptions options;
  options.seed = seed;
  options.duration_s = 60;
  options.parked_s = 0;
  options.stops = false;
  options.gyro_bias = {0.002, -0.003, 0.004};
  options.turn_centre = kTurnCentre;
  return Simulate(WheelsAndImu(), {}, options);
}

class UnfitAccelerometer : public testing::TestWithParam<uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, UnfitAccelerometer, testing::Values(1, 2, 3));

TEST_P(UnfitAccelerometer, LeavesNothingOfWhatItTold) {
  const Recording recording = Unfit(GetParam());
  const Drive with = Reckon(recording, true), never = Reckon(recording, false);
  ASSERT_GT(with.unfit_at, 0u);
  ASSERT_EQ(with.states.size(), never.states.size());
  EXPECT_EQ(with.rejected, never.rejected);  // no driven way is lost by the change
  EXPECT_EQ(with.states.back().reset_counter, never.states.back().reset_counter);
  for (size_t i = with.unfit_at; i < with.states.size(); ++i) {
    ASSERT_EQ(with.states[i].utime, never.states[i].utime);
    // Equal but for rounding: the frames differ.
    const Eigen::Vector3d bias = with.states[i].gyro_bias_rad_s - never.states[i].gyro_bias_rad_s;
    EXPECT_LT(bias.norm(), 1e-6);
    EXPECT_NEAR(with.states[i].turn_scale, never.states[i].turn_scale, 1e-6);
    EXPECT_EQ(with.states[i].wheel_scale, never.states[i].wheel_scale);
  }
  // The pose goes on from where it was, as the other one moves, but for the tilt that it had.
  const size_t from = with.unfit_at, to = with.states.size() - 1;
  const SE3 step = with.states[from - 1].T_OB.inverse() * with.states[from].T_OB;
  EXPECT_LT(step.translation().norm(), 0.02);
  EXPECT_LT(LogSO3(step.rotation()).norm(), 0.02);
  const SE3 motion = with.states[from].T_OB.inverse() * with.states[to].T_OB;
  const SE3 expected = never.states[from].T_OB.inverse() * never.states[to].T_OB;
  EXPECT_NEAR(LogSO3((expected.inverse() * motion).rotation()).z(), 0, 2e-3);
  const double way = expected.translation().norm();
  EXPECT_NEAR(motion.translation().norm(), way, 0.01 * way + 0.01);
  // Over this way it is gone, and nowhere faster than floors tilt.
  EXPECT_GT(Up(with.states[to]).z(), std::cos(1e-3));
  constexpr size_t kWindow = 100;
  for (size_t i = from; i + kWindow <= to; i += kWindow) {
    double driven = 0;
    for (size_t k = i; k < i + kWindow; ++k) {
      driven += (with.states[k].T_OB.inverse() * with.states[k + 1].T_OB).translation().norm();
    }
    const double change = (Up(with.states[i + kWindow]) - Up(with.states[i])).norm();
    ASSERT_LE(change, 1.1 * kFloorTilt * driven / kFloorTiltWay);
  }
  // Where the twin is instead may be wrong with the pose that was kept.
  const SE3 apart = with.states[from].T_OB.inverse() * never.states[from].T_OB;
  const Matrix6d& cov = with.states[from].cov_T_OB;
  const double doubt = cov(0, 0) + cov(1, 1) + cov(2, 2);
  EXPECT_GT(doubt, apart.translation().squaredNorm());
}

// A tilt that no floor has is no tilt that the robot leaves by driving.
TEST(TwinFrame, AnImpossibleTiltIsLeftAtOnce) {
  constexpr double kMost = 0.04;
  const SE3 T_OB_twin(ExpSO3({0, 0, 0.5}), {2, 0.1, 0});
  for (const double tilt : {0.03, 0.05}) {
    const SE3 T_OB(ExpSO3({0, 0, 0.6}) * ExpSO3({0, tilt, 0}), {2.1, 0, 0.05});
    const TwinFrame frame = FrameOfTwin(T_OB, T_OB_twin, kMost);
    const SE3 kept = frame.T_O_twin * T_OB_twin;
    EXPECT_EQ(frame.levelled, tilt > kMost);
    EXPECT_LT((kept.translation() - T_OB.translation()).norm(), 1e-12);
    const Eigen::Vector3d apart = LogSO3(T_OB.rotation().conjugate() * kept.rotation());
    EXPECT_NEAR(apart.norm(), frame.levelled ? tilt : 0, 1e-9);
    const FilterState state = GoOnAsTwin({}, frame, {});
    EXPECT_EQ(state.reset_counter, frame.levelled ? 1u : 0u);
  }
}

}  // namespace
}  // namespace gw::dr_ekf

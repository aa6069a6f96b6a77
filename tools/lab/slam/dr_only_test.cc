// What gw-slam --dr-only measures and says, on runs made here whose motion is known.
#include "tools/lab/slam/dr_only.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tools/lab/slam/dr_motion.h"
#include "tools/lab/slam/dr_report.h"

namespace gw::tools {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kGyroBias = 0.01;  // rad/s

RobotConfig Robot() {
  RobotConfig config;
  config.calibration.imu.present = true;
  config.calibration.wheel.present = true;
  return config;
}

// Stands for 1 s, then drives on a circle at 0.5 m/s and 0.5 rad/s for 20 s; wheels at 20 Hz, IMU
// at 100 Hz. dr_turn_scale: dead reckoning turns by so much more than the wheels.
DrOnlyRun Circle(double dr_turn_scale = 1) {
  DrOnlyRun run;
  SE3 T_OB;
  run.poses.push_back({{0}, 0, T_OB, false, 0});
  for (int i = 0; i < 420; ++i) {
    const bool moves = i >= 20;
    WheelSample sample;
    sample.utime_begin = {i * 50000};
    sample.utime = {(i + 1) * 50000};
    sample.dx_m = moves ? 0.025 : 0;
    sample.dyaw_rad = moves ? 0.025 : 0;
    run.wheels.push_back(sample);
    T_OB = T_OB * SE3(ExpSO3({0, 0, dr_turn_scale * sample.dyaw_rad}), {sample.dx_m, 0, 0});
    run.poses.push_back({sample.utime, 0, T_OB, false, run.wheels.size()});
  }
  for (int i = 0; i <= 2100; ++i) {
    run.gyro.push_back(
        {{i * 10000}, {0, 0, (i > 100 ? 0.5 : 0) + kGyroBias}, static_cast<size_t>(i / 5)});
  }
  run.messages = {{"IMU", 2101}, {"WHEEL", 420}};
  run.counters = dr_ekf::DrCounters();
  run.counters->imu_used = 2101;
  run.counters->wheel_used = 420;
  run.last = DrState();
  return run;
}

DrVerdict Judge(const DrOnlyRun& run, const RobotConfig& config = Robot()) {
  return JudgeDrRun(run, MeasureMotion(run, config.calibration), SumWheels(run.wheels, {}), config,
                    {});
}

TEST(DrMotion, MeasuresWayAndTurnOfDeadReckoningWheelsAndGyro) {
  const DrMotion motion = MeasureMotion(Circle(), Robot().calibration);
  EXPECT_NEAR(motion.way_m, 10, 1e-9);
  EXPECT_NEAR(*motion.wheel_way_m, 10, 1e-9);
  EXPECT_NEAR(motion.turn_rad, 10, 1e-9);  // more than a turn: not wrapped
  EXPECT_NEAR(*motion.wheel_turn_rad, 10, 1e-9);
  ASSERT_TRUE(motion.gyro);
  ASSERT_EQ(motion.gyro->standstills.size(), 1u);
  EXPECT_NEAR(motion.gyro->standstills[0].gyro_z_rad_s, kGyroBias, 1e-9);
  EXPECT_NEAR(motion.gyro->turn_rad, 10, 0.01);
  EXPECT_NEAR(motion.gyro->dr_turn_rad, 10, 1e-9);
  EXPECT_EQ(motion.uncovered.us, 0);
}

TEST(DrMotion, GyroIsTurnedIntoTheBody) {
  DrOnlyRun run = Circle();
  for (GyroReading& reading : run.gyro) reading.w_I_rad_s = {reading.w_I_rad_s.z(), 0, 0};
  Calibration calibration = Robot().calibration;
  Eigen::Matrix3d R_BI;  // x of the IMU is z of the body
  R_BI << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  calibration.imu.T_BI = SE3(Eigen::Quaterniond(R_BI), Eigen::Vector3d::Zero());
  EXPECT_NEAR(MeasureMotion(run, calibration).gyro->turn_rad, 10, 0.01);
}

TEST(DrMotion, IntervalsWithAResetInsideAreLeftOutOnBothSides) {
  DrOnlyRun run = Circle();
  for (size_t i = 200; i < run.poses.size(); ++i) {
    run.poses[i].reset_counter = 1;
    run.poses[i].T_OB = SE3(Eigen::Quaterniond::Identity(), {100, 0, 0}) * run.poses[i].T_OB;
  }
  const DrMotion motion = MeasureMotion(run, Robot().calibration);
  EXPECT_NEAR(motion.way_m, 10 - 0.025, 1e-9);
  EXPECT_NEAR(*motion.wheel_way_m, 10 - 0.025, 1e-9);
  EXPECT_EQ(motion.uncovered.us, 50000);
}

// Circle() again after itself, its times moved: wheels, gyro and states as the log would have them.
DrOnlyRun Twice(DurationUs moved, uint32_t reset_counter) {
  DrOnlyRun run = Circle();
  const size_t before = run.wheels.size();
  const DrOnlyRun again = Circle();
  for (DrPose pose : again.poses) {
    pose.utime = pose.utime + moved;
    pose.reset_counter = reset_counter;
    pose.wheels_before += before;
    run.poses.push_back(pose);
  }
  for (GyroReading reading : again.gyro) {
    reading.utime = reading.utime + moved;
    reading.wheels_before += before;
    run.gyro.push_back(reading);
  }
  for (WheelSample sample : again.wheels) {
    sample.utime = sample.utime + moved;
    sample.utime_begin = sample.utime_begin + moved;
    run.wheels.push_back(sample);
  }
  return run;
}

TEST(DrMotion, ALogThatFollowsItselfCountsTwice) {
  for (const int64_t moved_ms : {0, -5000, -100000}) {
    SCOPED_TRACE(moved_ms);
    const DrMotion motion = MeasureMotion(Twice(Milliseconds(moved_ms), 1), Robot().calibration);
    EXPECT_NEAR(motion.way_m, 20, 1e-9);
    EXPECT_NEAR(*motion.wheel_way_m, 20, 1e-9);
    EXPECT_NEAR(motion.gyro->turn_rad, 20, 0.03);
    EXPECT_EQ(motion.gyro->standstills.size(), 2u);
    EXPECT_EQ(motion.uncovered.us, 0);
  }
}

// The clock is set back by 50 ms; the filter waits until it is over and goes on in the same life.
TEST(DrMotion, AShortStepBackLosesOnlyItsOwnTime) {
  DrOnlyRun run = Circle();
  for (size_t i = 300; i < run.wheels.size(); ++i) {
    run.wheels[i].utime = run.wheels[i].utime - Milliseconds(50);
    run.wheels[i].utime_begin = run.wheels[i].utime_begin - Milliseconds(50);
  }
  run.wheels[300].utime_begin = run.wheels[300].utime;  // what an importer makes of it
  for (size_t i = 302; i < run.poses.size(); ++i) {
    run.poses[i].utime = run.poses[i].utime - Milliseconds(50);
  }
  run.poses.erase(run.poses.begin() + 301);
  const DrMotion motion = MeasureMotion(run, Robot().calibration);
  EXPECT_NEAR(*motion.wheel_way_m, 10, 0.06);
  EXPECT_LE(motion.uncovered.us, 100000);
}

TEST(WheelSum, ComposesEveryIncrementInCameraTime) {
  const DrOnlyRun run = Circle();
  WheelSum sum = SumWheels(run.wheels, Milliseconds(40));
  ASSERT_EQ(sum.poses.size(), 421u);
  EXPECT_EQ(sum.poses.front().utime.us, -40000);
  EXPECT_LT((sum.poses.back().T_OB.inverse() * run.poses.back().T_OB).Log().norm(), 1e-9);
  EXPECT_EQ(sum.gaps, 0);
  std::vector<WheelSample> lossy = run.wheels;
  lossy.erase(lossy.begin() + 10);
  EXPECT_EQ(SumWheels(lossy, {}).gaps, 1);
}

TEST(SlipSpans, OneForEachStretch) {
  DrOnlyRun run = Circle();
  for (const size_t i : {50u, 51u, 52u, 90u}) run.poses[i].slip = true;
  const std::vector<SlipSpan> spans = SlipSpans(run.poses);
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ((spans[0].end - spans[0].begin).us, 100000);
  EXPECT_EQ((spans[1].end - spans[1].begin).us, 0);
}

TEST(DrVerdict, ASoundRunHasNoProblem) {
  const DrVerdict verdict = Judge(Circle());
  EXPECT_THAT(verdict.problems, IsEmpty());
  EXPECT_THAT(verdict.facts, Contains(HasSubstr("way: 10.000 m by dead reckoning, 10.000 m")));
  EXPECT_THAT(VerdictText(verdict), HasSubstr("verdict: nothing to complain of"));
}

TEST(DrVerdict, WhatIsWrongIsNamed) {
  EXPECT_THAT(Judge(Circle(1.1)).problems, Contains(HasSubstr("differs from the gyro's integral")));

  DrOnlyRun slow = Circle();
  for (DrPose& pose : slow.poses) {
    pose.T_OB = SE3(pose.T_OB.rotation(), 0.8 * pose.T_OB.translation());
  }
  EXPECT_THAT(Judge(slow).problems, Contains(HasSubstr("way differs from the wheels' by -20.0 %")));

  DrOnlyRun high = Circle();
  high.poses.back().T_OB =
      SE3(Eigen::Quaterniond::Identity(), {0, 0, 0.5}) * high.poses.back().T_OB;
  EXPECT_THAT(Judge(high).problems, Contains(HasSubstr("height wanders by 0.50 m")));

  DrOnlyRun reset = Circle();
  reset.poses.back().reset_counter = 7;
  EXPECT_THAT(Judge(reset).problems, Contains(HasSubstr("began anew 1 times")));

  DrOnlyRun refused = Circle();
  refused.counters->wheel_used = 300;
  EXPECT_THAT(Judge(refused).problems, Contains(HasSubstr("WHEEL: 120 of 420 messages")));

  DrOnlyRun joined = Circle();
  joined.clock.Add({5000000});
  joined.clock.Add({1000000});
  EXPECT_THAT(Judge(joined).problems, Contains(HasSubstr("time goes back by 4.000 s")));

  DrOnlyRun found = Circle();
  found.found.push_back({{2500000}, dr_ekf::DrDiagnosis::kAccelUnfit});
  EXPECT_THAT(Judge(found).problems,
              Contains(HasSubstr("after 2.50 s: the accelerometer contradicts the wheels")));
}

TEST(DrVerdict, StreamsThatAreNotUsedAreNamedWithTheReason) {
  RobotConfig config = Robot();
  config.calibration.imu.present = false;
  EXPECT_THAT(Judge(Circle(), config).problems,
              Contains(HasSubstr("IMU is not used: the log has")));
  DrOnlyRun without = Circle();
  without.messages.erase("WHEEL");
  without.wheels.clear();
  without.counters->wheel_used = 0;
  EXPECT_THAT(Judge(without).problems, Contains(HasSubstr("WHEEL is not used: the configuration")));
}

}  // namespace
}  // namespace gw::tools

// The filter goes on when one sensor fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dr_ekf/test/filter_testing.h"

namespace gw::dr_ekf {
namespace {

struct LongestGap {
  Utime last = {0};
  DurationUs longest = {0};
  void Add(Utime t) {
    if (last.us != 0) longest = std::max(longest, t - last);
    last = t;
  }
};

TEST(DrFilterDropout, WithoutGyroTheWheelsCarryOn) {
  for (const auto calibration : {WheelsAndGyro, WheelsAndImu}) {
    const Recording r = Simulate(calibration(), {}, {.duration_s = 20});
    DrFilter filter = Make(r.calibration);
    LongestGap gap;
    DrState last;
    for (const Sample& sample : r.samples) {
      const auto* imu = std::get_if<ImuSample>(&sample);
      const double t = imu != nullptr ? (imu->utime - r.begin).seconds() : 0;
      if (imu != nullptr && t > 8 && t < 15) continue;
      for (const DrState& s : Feed(filter, sample).states) {
        const double at = (s.utime - r.begin).seconds();
        if (at > 8.3 && at < 15) {
          EXPECT_FALSE(s.imu_alive);
        }
        gap.Add(s.utime);
        last = s;
      }
    }
    EXPECT_LE(gap.longest, Milliseconds(40));  // two wheel periods
    EXPECT_TRUE(last.imu_alive);
    EXPECT_EQ(last.reset_counter, 0u);
    const Vector6d error = (last.T_OB.inverse() * TruthFromStart(r, last.utime)).Log();
    for (const int axis : {0, 1, 5}) {
      EXPECT_LT(std::abs(error[axis]), 4 * std::sqrt(last.cov_T_OB(axis, axis))) << axis;
    }
    EXPECT_LT(error.head<2>().norm(), 0.6);
  }
}

TEST(DrFilterDropout, WithoutWheelsTheCovarianceGrowsHonestly) {
  for (const auto calibration : {WheelsAndGyro, WheelsAndImu}) {
    int outside = 0;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      const Recording r = Simulate(calibration(), {}, {.seed = seed, .duration_s = 20});
      DrFilter filter = Make(r.calibration);
      LongestGap gap;
      DrState at_loss, at_end;
      for (const Sample& sample : r.samples) {
        const auto* wheel = std::get_if<WheelSample>(&sample);
        if (wheel != nullptr && wheel->utime - r.begin > Milliseconds(12000)) continue;
        for (const DrState& s : Feed(filter, sample).states) {
          gap.Add(s.utime);
          if (s.utime - r.begin < Milliseconds(12000)) at_loss = s;
          at_end = s;
        }
      }
      EXPECT_LE(gap.longest, Milliseconds(20));
      EXPECT_FALSE(at_end.wheels_alive);
      const auto spread = [](const DrState& s) { return s.cov_T_OB(0, 0) + s.cov_T_OB(1, 1); };
      EXPECT_GT(spread(at_end), 1.5 * spread(at_loss)) << r.calibration.imu.has_accel << seed;
      const Vector6d error = (at_end.T_OB.inverse() * TruthFromStart(r, at_end.utime)).Log();
      for (const int axis : {0, 1, 5}) {
        outside += std::abs(error[axis]) > 2.5 * std::sqrt(at_end.cov_T_OB(axis, axis));
      }
    }
    EXPECT_LE(outside, 4);  // of 60; 1.2 % are expected
  }
}

TEST(DrFilterDropout, WheelsInTheAirAreNotBelieved) {
  const Recording r = Simulate(WheelsAndGyro(), {}, {.duration_s = 6, .drive = false});
  DrFilter filter = Make(r.calibration);
  DrState last;
  int64_t drops = 0;
  for (Sample sample : r.samples) {
    if (auto* wheel = std::get_if<WheelSample>(&sample); wheel != nullptr) {
      if (wheel->utime - r.begin > Milliseconds(3000)) {
        wheel->contact.wheel_drop = true;
        wheel->dx_m = 0.01;
      }
    }
    const DrFilter::Output out = Feed(filter, sample);
    drops = out.counters.step.wheel_drops;
    if (!out.states.empty()) last = out.states.back();
  }
  EXPECT_GT(drops, 100);
  EXPECT_TRUE(last.slip);
  EXPECT_LT(last.T_OB.translation().norm(), 0.05);
}

}  // namespace
}  // namespace gw::dr_ekf

// What the inputs say is used as the calibration describes them.
#include <gtest/gtest.h>

#include <cmath>

#include "dr_ekf/core/noise_model.h"
#include "dr_ekf/test/filter_testing.h"

namespace gw::dr_ekf {
namespace {

TEST(DrFilterInput, TheBaseHeadingReplacesAGyro) {
  double with = 0, without = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    for (const bool heading : {false, true}) {
      const Recording r =
          Simulate(WheelsOnly(), {}, {.seed = seed, .duration_s = 30, .with_heading = heading});
      DrFilter filter = Make(r.calibration);
      const DrState last = FeedAll(filter, r.samples).back();
      const double error = std::abs((last.T_OB.inverse() * TruthFromStart(r, last.utime)).Log()[5]);
      (heading ? with : without) += error / 10;
      EXPECT_LT(error, 4 * std::sqrt(last.cov_T_OB(5, 5)));
    }
  }
  EXPECT_LT(with, 0.3 * without);
}

// The same robot, its clocks off by what the calibration says: the same result.
TEST(DrFilterInput, TimeOffsetsOfTheCalibrationAreTakenOut) {
  Calibration shifted = WheelsAndImu();
  shifted.wheel.time_offset_s = 0.0475;
  shifted.imu.time_offset_s = -0.01;
  const Recording a = Simulate(WheelsAndImu(), {}, {.duration_s = 8});
  const Recording b = Simulate(shifted, {}, {.duration_s = 8});
  DrFilter filter_a = Make(a.calibration), filter_b = Make(b.calibration);
  ExpectIdentical(FeedAll(filter_a, a.samples).back(), FeedAll(filter_b, b.samples).back());
}

// Wheel samples that come 50 ms after they were measured cost nothing but the extrapolation.
TEST(DrFilterInput, DelayedWheelsEndInTheSamePose) {
  const Recording on_time = Simulate(WheelsAndImu(), {}, {.duration_s = 10});
  const Recording delayed = Simulate(WheelsAndImu(), {}, {.duration_s = 10, .wheel_delay_s = 0.05});
  DrFilter a = Make(on_time.calibration), b = Make(delayed.calibration);
  const std::vector<DrState> sa = FeedAll(a, on_time.samples), sb = FeedAll(b, delayed.samples);
  const Utime t = on_time.begin + Milliseconds(9900);
  const Result<DrIncrement> ia = a.Increment(t - Milliseconds(500), t);
  const Result<DrIncrement> ib = b.Increment(t - Milliseconds(500), t);
  ASSERT_TRUE(ia.ok() && ib.ok());
  EXPECT_EQ(ia->T_BaBb.translation(), ib->T_BaBb.translation());
  EXPECT_EQ(ia->cov, ib->cov);
}

// A shock within one IMU sample, 80 m/s^2, is a change of speed by 0.4 m/s wherever the stamp of a
// wheel sample lies between the IMU's.
TEST(DrFilterInput, AShockIsWholeWhereAWheelSampleDividesIt) {
  constexpr int kShock = 400;  // of the IMU's samples, one every 5 ms
  const Calibration calibration = WheelsAndImu();
  for (const int divided_ms : {0, 1, 2, 3, 4}) {
    DrFilter filter = Make(calibration);
    Utime wheels;
    DrState last;
    for (int i = 0; i <= kShock + 1; ++i) {
      const Utime utime{5000 * i};
      if (i % 10 == 0 && i > 0) {
        WheelSample sample;
        sample.utime_begin = wheels;
        sample.utime = wheels = utime - Milliseconds(5 - divided_ms);
        sample.dx_m = 0.3 * (sample.utime - sample.utime_begin).seconds();
        filter.Push(sample);
      }
      ImuSample imu;
      imu.utime = utime;
      imu.has_accel = true;
      imu.w_I_rad_s.setConstant(i % 2 == 0 ? 1e-4 : -1e-4);  // one that stands is not believed
      imu.a_I_m_s2 = calibration.imu.T_BI.rotation().conjugate() *
                     Eigen::Vector3d(i == kShock ? 80.0 : 0.0, 0, kGravity);
      for (const DrState& state : filter.Push(imu).states) last = state;
    }
    EXPECT_NEAR(last.v_OB_B.x(), 0.3 + 0.4, 0.01) << divided_ms;
  }
}

TEST(DrFilterInput, RollAndPitchComeFromGravity) {
  Calibration calibration = WheelsAndImu();
  SimOptions options{.duration_s = 10, .parked_s = 2, .floor_tilt = 0.03};
  const Recording r = Simulate(calibration, {}, options);
  DrFilter filter = Make(r.calibration);
  const DrState last = FeedAll(filter, r.samples).back();
  EXPECT_TRUE(last.gravity_aligned);
  const Eigen::Vector3d up = last.T_OB.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d truth =
      r.TruthAt(last.utime).rotation().conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((up - truth).norm(), 0.005);
}

}  // namespace
}  // namespace gw::dr_ekf

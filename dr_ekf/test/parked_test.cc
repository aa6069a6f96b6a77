// A parked hour: still wheels and a still gyro mean a frozen pose, whatever the biases do, and what
// shakes the robot in between must not add up.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "common/core/random.h"
#include "dr_ekf/core/noise_model.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

constexpr int kHour = 3'600'000;        // ms
constexpr int kShakeEvery = 300'000;    // ms: a door, a cleaner's broom
constexpr int kShakeLasts = 200;        // ms
constexpr int kFlickerEvery = 420'000;  // ms: an encoder on the edge of a tick goes there and back

// Whole periods of shaking: the body ends where it was.
double Shake(int ms, double amplitude) {
  const int since = ms % kShakeEvery;
  if (ms < kShakeEvery || since >= kShakeLasts) return 0;
  return amplitude * std::sin(2 * M_PI * 5 * since / kShakeLasts);
}

ImuSample ImuAt(int ms, const ImuCalibration& imu, Eigen::Vector3d& gyro_bias,
                Eigen::Vector3d& accel_bias, CounterRng& rng) {
  const double root_rate = std::sqrt(imu.rate_hz);
  ImuSample s;
  s.utime = {1'000'000'000 + ms * int64_t{1000}};
  s.has_accel = imu.has_accel;
  const Eigen::Vector3d up_I = imu.T_BI.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  s.a_I_m_s2 = kGravity * up_I;
  for (int k = 0; k < 3; ++k) {
    gyro_bias[k] += imu.gyro_walk / root_rate * rng.Normal();
    accel_bias[k] += imu.accel_walk / root_rate * rng.Normal();
    s.w_I_rad_s[k] = gyro_bias[k] + imu.gyro_noise * root_rate * rng.Normal() + Shake(ms, 0.05);
    s.a_I_m_s2[k] += accel_bias[k] + imu.accel_noise * root_rate * rng.Normal() + Shake(ms, 0.5);
  }
  return s;
}

WheelSample WheelAt(int ms, const WheelCalibration& wheel) {
  WheelSample s;
  s.utime = {1'000'000'000 + ms * int64_t{1000}};
  s.utime_begin = {s.utime.us - 20'000};
  s.has_ticks = true;
  const int since = ms % kFlickerEvery;
  const double tick_m = 1 / wheel.ticks_per_metre;
  if (ms >= kFlickerEvery && since == 0) s.dx_m = 0.5 * tick_m;
  if (ms >= kFlickerEvery && since == 20) s.dx_m = -0.5 * tick_m;
  return s;
}

class DrParked : public testing::TestWithParam<Calibration (*)()> {};
INSTANTIATE_TEST_SUITE_P(Modes, DrParked, testing::Values(WheelsOnly, WheelsAndGyro, WheelsAndImu));

TEST_P(DrParked, AnHourMovesThePoseByMillimetresAndLessThanATenthOfADegree) {
  const Calibration calibration = GetParam()();
  DrFilter filter = std::move(DrFilter::Create({}, calibration)).value();
  CounterRng rng(21, 0, 0);
  Eigen::Vector3d gyro_bias(0.01, -0.015, 0.02), accel_bias(0.05, -0.03, 0.1);
  DrState first, last;
  int64_t moving = 0;
  for (int ms = 10; ms < kHour; ms += 10) {
    std::vector<DrState> states;
    if (calibration.imu.present) {
      states = filter.Push(ImuAt(ms, calibration.imu, gyro_bias, accel_bias, rng)).states;
    }
    if (ms % 20 == 0) {
      for (DrState& s : filter.Push(WheelAt(ms, calibration.wheel)).states) states.push_back(s);
    }
    for (const DrState& s : states) {
      if (ms <= 2000) first = s;
      moving += !s.stationary;
      last = s;
    }
  }
  const Vector6d drift = (first.T_OB.inverse() * last.T_OB).Log();
  std::printf("drift in an hour: %.4f mm, heading %.5f deg, tilt %.5f deg; %lld states not held\n",
              1000 * drift.head<3>().norm(), std::abs(drift[5]) * 180 / M_PI,
              drift.segment<2>(3).norm() * 180 / M_PI, static_cast<long long>(moving));
  EXPECT_TRUE(last.stationary);
  // An accelerometer integrates each shake, and still wheels hold against it only as far as a body
  // does not rock; 0.4 mm for each of eleven.
  EXPECT_LT(drift.head<3>().norm(), calibration.imu.has_accel ? 4.4e-3 : 1e-3);
  EXPECT_LT(std::abs(drift[5]), 0.1 * M_PI / 180);
  EXPECT_GT(moving, 0);  // it was shaken out of its rest
}

}  // namespace
}  // namespace gw::dr_ekf

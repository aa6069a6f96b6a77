// A small differential-drive robot for the tests of this folder: smooth random driving, and the
// samples its sensors would give, with exactly the noise that the filter is told (so that a test of
// honesty tests the filter and not the guess).
#pragma once

#include <variant>
#include <vector>

#include "common/camera/calibration.h"
#include "common/config/dr_ekf_config.h"
#include "common/contract/samples.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "dr_ekf/core/dr_filter.h"

namespace gw::dr_ekf {

struct SlipSpan {
  double begin_s = 0, end_s = 0;
  double extra_v = 0;   // m/s that the wheels turn and the robot does not drive
  double extra_w = 0;   // rad/s likewise
  double spin = 1;      // wheel speed / true speed; the robot goes on as it was
  double traction = 1;  // true speed / wheel speed; the wheels go on as they were
  double ramp_s = 0.0;  // fades in and out over this
  double push_y = 0;    // m/s sideways, that the wheels do not notice
  double push_w = 0;    // rad/s likewise
};

struct SimOptions {
  uint64_t seed = 1;
  double duration_s = 30;
  double parked_s = 1.0;  // at the start
  bool drive = true;      // false: parked all the time
  bool stops = true;      // stand still now and then
  double max_speed = 0.5;
  double max_turn = 0.8;
  double acceleration = 0.8;    // m/s^2, of starts and stops
  double wheel_noise = 1.0;     // times the noise that the filter is told
  double bumps_per_minute = 0;  // thresholds of 1 cm; only with an accelerometer
  double true_scale = 1.0;
  double true_yaw_scale = 1.0;
  double turn_per_way = 0;  // rad/m that the robot turns and its wheels do not tell
  Eigen::Vector3d gyro_scale = Eigen::Vector3d::Ones();  // true / measured, axes of the IMU
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  double gyro_step_at_s = -1;  // the z bias jumps here
  double gyro_step = 0;
  double floor_tilt = 0.005;  // rad, roll and pitch along the way; only with an accelerometer
  bool with_heading = false;
  double crab = 0;  // way of B to the left per way of the wheels: an IMU that looks askew
  // m, x in B of the point that moves as the wheels say: a base that cannot steer, an IMU
  // elsewhere.
  double turn_centre = 0;
  double wheel_delay_s = 0;  // arrival after measurement
  std::vector<SlipSpan> slips = {};
};

using Sample = std::variant<ImuSample, WheelSample>;

struct Recording {
  Calibration calibration;
  std::vector<Sample> samples;  // in order of arrival
  Utime begin;
  std::vector<SE3> T_GB;      // truth every millisecond from `begin`
  std::vector<double> speed;  // m/s, likewise
  const SE3& TruthAt(Utime utime) const;
};

// Kobuki-like base: 50 Hz wheels, and if asked a 100 Hz gyro or 6-axis IMU, mounted off-centre.
Calibration WheelsOnly();
Calibration WheelsAndGyro();
Calibration WheelsAndImu();

Recording Simulate(const Calibration& calibration, const DrEkfConfig& config,
                   const SimOptions& options);

DrFilter::Output Feed(DrFilter& filter, const Sample& sample);
// Everything that the filter publishes for these samples.
std::vector<DrState> FeedAll(DrFilter& filter, const std::vector<Sample>& samples);

}  // namespace gw::dr_ekf

// What the dead-reckoning filter knows at one instant: estimate, covariance, and the memory that
// its decisions need (who is alive, who is still). Copied into the history, so that a late
// measurement can go back to it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "common/core/se3.h"
#include "common/core/time.h"
#include "dr_ekf/core/noise_factor.h"
#include "dr_ekf/core/noise_model.h"
#include "dr_ekf/core/slip_gate.h"
#include "dr_ekf/core/stamp_error.h"

namespace gw::dr_ekf {

// Error state. Pose errors are right perturbations of T_OS; S has its origin at the IMU and the
// axes of B (without IMU: S is B). The clone is the pose at the begin of the running wheel
// interval: wheel samples measure motion from there to now.
inline constexpr int kPose = 0;         // 6: translation, rotation
inline constexpr int kVelocity = 6;     // 3: of S in O, in S
inline constexpr int kGyroBias = 9;     // 3: in I
inline constexpr int kAccelBias = 12;   // 3: in I
inline constexpr int kWheelScale = 15;  // 1: true way / measured way
inline constexpr int kYawScale = 16;    // 1: true / measured yaw of the wheels
// 1: rad per metre that the robot turns and its wheels do not tell: left and right are not alike
inline constexpr int kTurnPerWay = 17;
inline constexpr int kGyroScale = 18;  // 3: in I, true / measured rate
// How the wheels roll, seen in B as the IMU's mounting has it
// (docs/adr/0024-where-the-wheels-roll.md).
inline constexpr int kClimb = 21;       // 1: rise of B per way driven
inline constexpr int kCrab = 22;        // 1: way of B to the left per way driven
inline constexpr int kTurnCentre = 23;  // 1: x in B of the point that moves as the wheels say
inline constexpr int kClone = 24;       // 6
// Errors of the wheels' sums, way (m) and turn (rad): what a sum is off for as long as its sample
// is the newest (time error of the stamp, quantisation), but not for good.
inline constexpr int kCloneSum = 30;  // 2: of the sample at the clone
inline constexpr int kNewSum = 32;    // 2: of the sample that is being used
inline constexpr int kErrorSize = 34;
using ErrorVector = Eigen::Matrix<double, kErrorSize, 1>;
using ErrorMatrix = Eigen::Matrix<double, kErrorSize, kErrorSize>;

// Decisions that the filter took, counted. Part of the state so that replaying a late measurement
// does not count twice.
struct StepCounters {
  int64_t gated_wheel_way = 0;
  int64_t gated_wheel_yaw = 0;
  int64_t wheel_drops = 0;
  int64_t slips = 0;
  int64_t gyro_bias_jumps = 0;
  int64_t parted = 0;  // times the watchdog restarted a part of the filter
};

struct FilterState {
  Utime utime;
  uint32_t reset_counter = 0;

  SE3 T_OS;
  Eigen::Vector3d v_OS_S = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_OS_S = Eigen::Vector3d::Zero();  // newest rate, bias removed; not estimated
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_scale = Eigen::Vector3d::Ones();
  double wheel_scale = 1.0;
  double yaw_scale = 1.0;
  double turn_per_way = 0;  // rad/m
  double climb = 0;
  double crab = 0;
  double turn_centre = 0;  // m, in B
  SE3 T_OS_clone;
  Eigen::Vector2d clone_sum = Eigen::Vector2d::Zero();  // estimated errors of the sums
  Eigen::Vector2d new_sum = Eigen::Vector2d::Zero();
  ErrorMatrix P = ErrorMatrix::Zero();
  // Linear map of the error at the history entry before to the error here (noise aside): products
  // of it correlate the errors of two instants.
  ErrorMatrix transition = ErrorMatrix::Identity();

  // Corrections of the pose (K S K^T of the updates, smoothed over kCorrectionMemory): innovations
  // are white, so this is the white noise that corrections put into relative motion. In S; m^2/s,
  // rad^2/s.
  Matrix6d correction_rate = Matrix6d::Zero();

  double usual_speed = 0;  // m/s, mean over kUsualSpeedMemory

  // Running wheel interval.
  bool has_clone = false;
  Utime clone_utime;
  bool way_unmeasured = true;  // since the clone: no accelerometer
  bool yaw_unmeasured = true;  // since the clone: no gyro

  // Newest inputs.
  bool has_imu = false;
  bool imu_has_accel = false;
  Utime imu_utime;
  Eigen::Vector3d gyro_B = Eigen::Vector3d::Zero();   // as measured, axes of B
  Eigen::Vector3d accel_B = Eigen::Vector3d::Zero();  // as measured, axes of B
  bool has_wheel = false;
  Utime wheel_utime;
  bool wheel_drop = false;
  bool has_heading = false;
  double heading = 0;
  bool heading_used = false;  // the newest wheel interval took its yaw from the base's heading
  double turn_without_heading = 0;  // rad, of the wheels since the base's heading changed
  bool heading_stuck = false;
  double turn_without_wheels = 0;  // rad, of the gyro since the wheels' heading changed
  bool wheel_turn_stuck = false;
  // Found out: the wheels read zero, both way and turn, while the IMU feels motion.
  bool wheels_stand = false;
  // Found out: accelerometer and vision both contradict how far the wheels say that they go.
  bool wheels_contradicted = false;

  // Gravity and floor.
  double floor = 0;  // m, height of the floor in O
  bool aligned = false;
  bool leveling = false;
  Utime leveling_end;

  // Stillness.
  bool stationary = false;
  bool wheel_still = false;
  Utime wheel_still_since;
  double still_way = 0;  // drift of the encoders while still
  double still_yaw = 0;
  Utime imu_still_since;
  Eigen::Vector3d gyro_reference = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_reference = Eigen::Vector3d::Zero();

  StampError stamp_error;  // of the wheels' samples

  // Slip.
  bool slip = false;
  Utime slip_end;
  double speed_doubt = 0;  // m/s, one sigma of the wheels' speed where nothing else measures it
  SlipGate yaw_gate;       // wheels against gyro
  SlipGate forward_gate;   // wheels against accelerometer
  SlipGate sideways_gate;
  SlipGate yaw_watch{.memory = kWatchMemory};  // likewise, where no slip is flagged
  SlipGate way_watch{.memory = kWatchMemory};  // wheels against the filter's way as it became
  NoiseFactor turn_noise{std::log(kTurnNoisePrior)};    // of the wheels, per angle turned
  NoiseFactor accel_noise{std::log(kAccelNoisePrior)};  // of the way by the accelerometer
  bool scale_untold = false;    // the stamps are too bad to tell the wheels' scale
  bool rolling_untold = false;  // the way of this interval is not that of wheels that roll
  bool accel_unfit = false;     // found out: DrFilter leaves this state for that of the twin
  double recent_slips = 0;      // times the accelerometer found slip, forgotten over kSlipsMemory
  double recent_stands = 0;     // likewise, of wheels that read zero
  Utime accused_until;  // vision accused the wheels; the accelerometer is asked more closely

  StepCounters counters;
};

}  // namespace gw::dr_ekf

// Inertial unit and wheel odometry of the simulated robot.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/contract/samples.h"
#include "tools/sim/sim/base.h"
#include "tools/sim/sim/scenario.h"

namespace gw::sim {

// A sample is the mean over the interval since the sample before, stamped at its middle: what a
// sensor does whose filter fits its rate.
class ImuSensor {
 public:
  ImuSensor(const ImuConfig& config, const SE3& T_BI, uint64_t seed);

  // Pose at the end and velocity of the IMU's origin at the end of the interval of length dt;
  // speed: m/s of the robot, which shakes with it.
  ImuSample Measure(Utime end, double dt, const SE3& T_GB, const Eigen::Vector3d& v_GI,
                    double speed);

  // After a jump of the truth that the sensor does not feel.
  void Forget() { first_ = true; }

  const Eigen::Vector3d& gyro_bias() const { return gyro_bias_; }

 private:
  ImuConfig config_;
  SE3 T_BI_;
  uint64_t seed_;
  bool first_ = true;
  Eigen::Quaterniond q_GI_before_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_before_ = Eigen::Vector3d::Zero();
  // Turn (rad) and velocity (m/s) of the shaking at this instant, axes of the IMU.
  struct Shake {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
  };
  Shake ShakeAt(Utime t, double speed) const;

  Eigen::Vector3d gyro_bias_, gyro_scale_, accel_bias_;
  Shake shake_before_;
  int64_t seq_ = 0;
};

// A Kobuki's packet: encoder ticks, the motion they mean, the base's own gyro heading, contact.
class WheelSensor {
 public:
  WheelSensor(double track_m, double ticks_per_metre, uint64_t seed);

  // Ways of the wheels' rims (m) and true heading at `now`.
  WheelSample Measure(Utime now, double left_way, double right_way, double yaw, bool bumper);
  // The truth jumped to this heading unnoticed.
  void Forget(double yaw) { yaw_before_ = yaw; }

 private:
  double track_m_, ticks_per_metre_;
  uint64_t seed_;
  int64_t left_before_ = 0, right_before_ = 0;
  Utime before_;
  double gyro_scale_, gyro_drift_rad_s_;
  double yaw_before_ = 0, heading_ = 0;
  int64_t seq_ = 0;
};

}  // namespace gw::sim

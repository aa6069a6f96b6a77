// What the drivers, the simulator and the importer measure. Times are those of the measurement,
// not of arrival. seq counts up by one per channel and sender; a gap means loss.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/core/image_view.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw {

enum class EmitterState : int32_t { kUnknown = 0, kOff = 1, kOn = 2 };

// One instant of the camera: stereo (left, right) or RGB-D (left, depth).
struct CameraFrame {
  Utime utime;  // mid-exposure
  int64_t seq = 0;
  int32_t exposure_us = 0;  // 0 = unknown
  EmitterState emitter = EmitterState::kUnknown;
  ImageView left;
  ImageView right;  // empty for RGB-D
  ImageView depth;  // empty for stereo; same size as left
};

// Gyro and accelerometer in the IMU frame I.
struct ImuSample {
  Utime utime;
  int64_t seq = 0;
  Eigen::Vector3d w_I_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d a_I_m_s2 =
      Eigen::Vector3d::Zero();  // specific force: +g along the up axis at rest
  bool has_accel = false;
};

struct ContactFlags {
  bool bumper = false, cliff = false, wheel_drop = false;
};

// Wheel odometry of one interval (utime_begin, utime].
struct WheelSample {
  Utime utime;        // end of the interval
  Utime utime_begin;  // begin; equals the utime of the sample before, unless one was lost
  int64_t seq = 0;
  bool has_ticks = false;
  uint16_t left_ticks = 0, right_ticks = 0;  // raw encoder counts at utime, wrapping at 65536
  // Motion of B over the interval, in B at its begin, before any correction.
  double dx_m = 0, dy_m = 0, dyaw_rad = 0;
  bool has_heading = false;
  double heading_rad = 0;  // the base's own gyro heading at utime, wrapping at +-pi
  ContactFlags contact;
};

// Where the body truly was. Only simulation and imported recordings have it; no estimator may use
// it.
struct GroundTruth {
  Utime utime;
  int64_t seq = 0;
  SE3 T_GB;  // body in the frame of the ground truth
};

struct BaseCommand {
  Utime utime;
  int64_t seq = 0;
  double v_m_s = 0;    // forward
  double w_rad_s = 0;  // counter-clockwise
};

}  // namespace gw

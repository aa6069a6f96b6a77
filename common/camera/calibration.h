// Calibration of the sensors, as the robot's YAML states it (section `calibration`).
// Nothing here has a safe default: a wrong calibration is worse than none.
#pragma once

#include <array>

#include "common/core/fields.h"
#include "common/core/se3.h"

namespace gw {

enum class CameraKind {
  kStereo,  // two grey images; rectified by us unless they already are
  kRgbd,    // one grey image and a depth image registered to it, pixel by pixel
};

// Pinhole with radial-tangential distortion (Brown-Conrady, OpenCV's order k1 k2 p1 p2 k3).
struct PinholeIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  std::array<double, 5> radtan{};         // k1 k2 p1 p2 k3

  bool distorted() const {
    for (const double k : radtan) {
      if (k != 0) return true;
    }
    return false;
  }

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field(
        "fx", fx,
        {.min = 1, .max = 1e5, .unit = "px", .required = true, .text = "focal length, horizontal"});
    v.Field(
        "fy", fy,
        {.min = 1, .max = 1e5, .unit = "px", .required = true, .text = "focal length, vertical"});
    v.Field("cx", cx,
            {.min = 0,
             .max = 1e5,
             .unit = "px",
             .required = true,
             .text = "principal point, horizontal"});
    v.Field("cy", cy,
            {.min = 0,
             .max = 1e5,
             .unit = "px",
             .required = true,
             .text = "principal point, vertical"});
    v.Field("radtan", radtan,
            {.min = -100, .max = 100, .text = "distortion k1 k2 p1 p2 k3; all zero: none"});
  }
};

struct CameraCalibration {
  CameraKind kind = CameraKind::kRgbd;
  int width = 0;
  int height = 0;
  double rate_hz = 30;
  PinholeIntrinsics left;   // the grey image of an RGB-D camera
  PinholeIntrinsics right;  // stereo only
  double readout_s = 0;     // rolling shutter: from the first to the last row; 0 = global shutter
  SE3 T_C0C1;               // stereo only: right camera in the frame of the left
  double depth_unit_m = 0.001;  // RGB-D only: metres per unit of the depth image
  double depth_min_m = 0.3;     // depths outside [min, max] count as no depth
  double depth_max_m = 8.0;
  double depth_baseline_m =
      0.08;  // RGB-D only: baseline of the virtual right camera (u_right = u - fx*b/z)
  double disparity_sigma_px = 0.1;  // RGB-D only: of fx*b/z, from image to image
  SE3 T_BC;  // left camera (optical frame, as mounted, before rectification) in the body

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Enum("kind", kind, {{"stereo", CameraKind::kStereo}, {"rgbd", CameraKind::kRgbd}},
           {.required = true,
            .text = "what one camera message holds: a stereo pair, or grey and depth"});
    v.Field("width", width,
            {.min = 64, .max = 4096, .unit = "px", .required = true, .text = "image width"});
    v.Field("height", height,
            {.min = 64, .max = 4096, .unit = "px", .required = true, .text = "image height"});
    v.Field("rate_hz", rate_hz,
            {.min = 1,
             .max = 200,
             .unit = "Hz",
             .required = true,
             .text = "nominal frame rate; 'per frame' sigmas refer to 30 Hz frames"});
    v.Field("readout_s", readout_s,
            {.min = 0,
             .max = 0.1,
             .unit = "s",
             .text = "rolling shutter: time from the first to the last row; 0: global shutter"});
    v.Section("left", left, {.required = true, .text = "left (or only) camera"});
    v.Section("right", right, {.text = "right camera; required for kind: stereo"});
    v.Pose("T_C0C1", T_C0C1,
           {.text = "right camera in the frame of the left; required for kind: stereo"});
    v.Field("depth_unit_m", depth_unit_m,
            {.min = 1e-6,
             .max = 0.1,
             .unit = "m",
             .text = "metres per unit of the depth image (TUM 0.0002, RealSense 0.001)"});
    v.Field("depth_min_m", depth_min_m,
            {.min = 0.01, .max = 10, .unit = "m", .text = "smallest depth that is used"});
    v.Field("depth_max_m", depth_max_m,
            {.min = 0.1,
             .max = 1000,
             .unit = "m",
             .text = "largest depth that is used for new landmarks and residuals"});
    v.Field("depth_baseline_m", depth_baseline_m,
            {.min = 0.001,
             .max = 1,
             .unit = "m",
             .text = "RGB-D only: baseline in which disparities are counted; that of the sensor"});
    v.Field(
        "disparity_sigma_px", disparity_sigma_px,
        {.min = 0.01,
         .max = 10,
         .unit = "px",
         .text =
             "RGB-D only: standard deviation of the disparity fx * depth_baseline_m / depth "
             "that a depth is made from (RealSense D4xx 0.05 at its baseline; a Kinect "
             "whose depth and colour are not taken at once 0.3); sets how strongly depth counts"});
    v.Pose("T_BC", T_BC,
           {.required = true,
            .text = "left camera (optical: x right, y down, z forward) in the body frame"});
  }
};

// IMU noise as datasheets give it (continuous-time densities).
struct ImuCalibration {
  bool present = false;
  bool has_accel = true;
  double rate_hz = 200;
  SE3 T_BI;                   // IMU in the body frame
  double time_offset_s = 0;   // t_imu = t_camera + time_offset_s
  double gyro_noise = 2e-4;   // rad/s/sqrt(Hz)
  double gyro_walk = 3e-5;    // rad/s^2/sqrt(Hz)
  double accel_noise = 2e-3;  // m/s^2/sqrt(Hz)
  double accel_walk = 3e-4;   // m/s^3/sqrt(Hz)

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("present", present, {.required = true, .text = "whether the robot has an IMU or gyro"});
    v.Field("has_accel", has_accel, {.text = "false: gyro alone"});
    v.Field("rate_hz", rate_hz, {.min = 1, .max = 4000, .unit = "Hz", .text = "nominal rate"});
    v.Pose("T_BI", T_BI, {.text = "IMU in the body frame"});
    v.Field("time_offset_s", time_offset_s,
            {.min = -1,
             .max = 1,
             .unit = "s",
             .text = "IMU time minus camera time of the same instant"});
    v.Field("gyro_noise", gyro_noise,
            {.min = 1e-7, .max = 1, .unit = "rad/s/sqrt(Hz)", .text = "gyro noise density"});
    v.Field("gyro_walk", gyro_walk,
            {.min = 0, .max = 1, .unit = "rad/s^2/sqrt(Hz)", .text = "gyro bias random walk"});
    v.Field(
        "accel_noise", accel_noise,
        {.min = 1e-6, .max = 10, .unit = "m/s^2/sqrt(Hz)", .text = "accelerometer noise density"});
    v.Field(
        "accel_walk", accel_walk,
        {.min = 0, .max = 10, .unit = "m/s^3/sqrt(Hz)", .text = "accelerometer bias random walk"});
  }
};

// Differential-drive base. Wheel messages already hold metres and radians; the noise grows with the
// way.
struct WheelCalibration {
  bool present = false;
  double rate_hz = 50;
  double time_offset_s =
      0;  // t_wheel = t_camera + time_offset_s (Kobuki: transport delay, measured 0.0475)
  double ticks_per_metre = 11724.4;  // Kobuki: 2578.33 ticks / (0.07 m * pi)
  double track_width_m = 0.23;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Field("present", present, {.required = true, .text = "whether the robot has wheel odometry"});
    v.Field("rate_hz", rate_hz, {.min = 1, .max = 1000, .unit = "Hz", .text = "nominal rate"});
    v.Field("time_offset_s", time_offset_s,
            {.min = -1,
             .max = 1,
             .unit = "s",
             .text = "wheel time minus camera time of the same instant"});
    v.Field(
        "ticks_per_metre", ticks_per_metre,
        {.min = 1, .max = 1e7, .unit = "1/m", .text = "encoder ticks per metre of wheel travel"});
    v.Field("track_width_m", track_width_m,
            {.min = 0.05, .max = 5, .unit = "m", .text = "distance between the two driven wheels"});
  }
};

struct Calibration {
  CameraCalibration camera;
  ImuCalibration imu;
  WheelCalibration wheel;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Section("camera", camera, {.required = true, .text = "camera"});
    v.Section("imu", imu, {.required = true, .text = "IMU or gyro"});
    v.Section("wheel", wheel, {.required = true, .text = "wheel odometry"});
  }
};

}  // namespace gw

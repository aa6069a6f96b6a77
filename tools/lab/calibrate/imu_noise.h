// The noise of an IMU, from a recording of a robot that stands still for an hour.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/camera/calibration.h"
#include "common/contract/samples.h"
#include "common/core/result.h"
#include "tools/lab/calibrate/allan.h"

namespace gw::calibrate {

// x, y, z of one sensor, in its own axes.
struct TriadNoise {
  std::array<NoiseModel, 3> axes;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
};

struct ImuNoise {
  double parked_s = 0;  // the longest standstill of the recording, which everything is of
  double rate_hz = 0;
  int64_t filled = 0;  // samples that were lost in it, interpolated
  TriadNoise gyro;     // rad/s
  bool has_accel = false;
  TriadNoise accel;  // m/s^2
};

inline constexpr double kShortestParked = 60;  // s

// A second is still when the wheels do not turn and neither gyro nor accelerometer leaves its usual
// mean; a hole of more than 0.1 s ends a standstill. Error kBadData: no standstill of
// kShortestParked, or a gyro that always reads the same.
Result<ImuNoise> MeasureImuNoise(const std::vector<ImuSample>& imu,
                                 const std::vector<WheelSample>& wheels);

// The largest of the axes, where one is determined, else `given`.
double LargestDensity(const TriadNoise& sensor, double given);
double LargestWalk(const TriadNoise& sensor, double given);

// The calibration with what was determined.
ImuCalibration WithNoise(const ImuCalibration& given, const ImuNoise& found);

// What is wrong with units and axes of a sensor at rest; a sentence with its number and the fix for
// each.
std::vector<std::string> JudgeStandstill(const ImuNoise& found, const Calibration& given);

}  // namespace gw::calibrate

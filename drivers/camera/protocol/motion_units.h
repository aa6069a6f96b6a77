// Raw numbers of the motion module of a D435i in SI units and camera axes.
//
// The sensor's axes are turned by diag(-1, 1, -1) against those of the depth camera (x right, y
// down, z forward). At rest upright a_I is about (0, -9.8, 0) in camera axes: specific force points
// up. Scales are those of the camera's firmware, not of the kernel's in_*_scale.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "drivers/camera/protocol/hardware_monitor.h"

namespace gw::camera {

// The angular rate in rad/s. A step is 0.1 deg/s in the low 16 bits with firmware before 5.16, and
// 0.0001 deg/s from 5.16 on.
Eigen::Vector3d GyroFromRaw(const std::array<int64_t, 3>& raw, const FirmwareVersion& firmware);
// The specific force in m/s^2; a step is 0.001 g.
Eigen::Vector3d AccelFromRaw(const std::array<int64_t, 3>& raw);

// The number to write to sampling_frequency for a rate in Hz: the firmware takes the place of the
// rate in its table, not the rate. Empty when no D435i has this rate.
std::optional<int> SamplingFrequencyCode(int rate_hz);

}  // namespace gw::camera

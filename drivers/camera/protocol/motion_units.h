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

// rad/s. Firmware before 5.16: 0.1 deg/s a step in the low 16 bits; from 5.16 on 0.0001 deg/s.
Eigen::Vector3d GyroFromRaw(const std::array<int64_t, 3>& raw, const FirmwareVersion& firmware);
// m/s^2; a step is 0.001 g.
Eigen::Vector3d AccelFromRaw(const std::array<int64_t, 3>& raw);

// What is to be written to sampling_frequency for a rate in Hz: the firmware takes the place of the
// rate in its table, not the rate. Empty: no D435i has this rate.
std::optional<int> SamplingFrequencyCode(int rate_hz);

}  // namespace gw::camera

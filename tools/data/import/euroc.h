// EuRoC MAV / ASL (Burri et al. 2016): mav0/cam0, cam1, imu0, state_groundtruth_estimate0, and
// odom0 where a recording has wheels.
#pragma once

#include <filesystem>

#include "tools/data/import/recording.h"

namespace gw::importer {

// source: the folder that holds mav0, or mav0. The body is the wheels' frame where there are wheels
// (T_BS of odom0/sensor.yaml), else the data set's (the IMU for EuRoC). Images are stored as they
// are, distorted and not rectified; the calibration says so. A pair has equal stamps in both
// cameras.
Result<Recording> ReadEuroc(const std::filesystem::path& source, const ReadOptions& options);

}  // namespace gw::importer

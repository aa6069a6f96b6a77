// CID-SIMS (Zhang et al. 2023), the paper's public benchmark: RGB-D, IMU and wheels.
#pragma once

#include <filesystem>
#include <string>

#include "tools/import/recording.h"

namespace gw::importer {

enum class ImuMatrix {
  kAuto,         // whichever makes the gyro agree with the camera's true rotation
  kImuToCamera,  // T_ItoC as its name says
  kCameraToImu,  // T_ItoC is in truth its inverse
};

struct CidSimsOptions : ReadOptions {
  std::filesystem::path calibration;  // empty: calibration.yaml in the source or its parent folder
  std::string mount;                  // "high" or "low": which camera mounting was recorded
  ImuMatrix imu_matrix = ImuMatrix::kAuto;
};

// Body: the wheel odometer's frame. Ground truth of the camera is moved to the body.
Result<Recording> ReadCidSims(const std::filesystem::path& source, const CidSimsOptions& options);

}  // namespace gw::importer

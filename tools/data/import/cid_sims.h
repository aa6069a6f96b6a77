// CID-SIMS (Zhang et al. 2023), the public benchmark of Du, Peng, Vela, "Good Weights", arXiv
// 2509.22910: RGB-D, IMU and wheels.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/data/import/recording.h"
#include "tools/data/import/trajectory.h"

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

// Camera with the image size that its intrinsics are stated for, IMU noise and offset, wheel base
// from the data set's calibration file; T_BI is left for SetImuPose. mount as in CidSimsOptions.
// Returns T_ItoC as the file has it.
Result<SE3> ReadCidSimsCalibration(const std::filesystem::path& file, const std::string& mount,
                                   Recording& recording);

// Sets T_BI from T_ItoC; kAuto needs the samples and the camera's ground truth. Notes the decision.
void SetImuPose(const SE3& T_ItoC, ImuMatrix choice, const std::vector<StampedPose>& T_GC,
                Recording& recording);

// Body: the wheel odometer's frame. Ground truth of the camera is moved to the body.
Result<Recording> ReadCidSims(const std::filesystem::path& source, const CidSimsOptions& options);

}  // namespace gw::importer

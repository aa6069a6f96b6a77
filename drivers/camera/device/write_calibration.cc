#include "drivers/camera/device/write_calibration.h"

#include <filesystem>
#include <fstream>

#include "common/camera/depth_sensors.h"
#include "common/config/writer.h"

namespace gw::camera {
namespace {

// Depth images of D4xx cameras are in mm unless an expert changed it.
constexpr double kDepthUnitM = 0.001;

}  // namespace

RobotConfig WithCalibration(RobotConfig config, const DepthCalibration& calibration) {
  CameraCalibration& camera = config.calibration.camera;
  camera.left = {calibration.camera.fx,
                 calibration.camera.fy,
                 calibration.camera.cx,
                 calibration.camera.cy,
                 {}};
  if (camera.kind == CameraKind::kStereo) {
    camera.right = camera.left;
    camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {calibration.baseline_m, 0, 0});
  } else {
    camera.depth_unit_m = kDepthUnitM;
    camera.depth_baseline_m = calibration.baseline_m;
    camera.disparity_sigma_px = kRealSenseD435.disparity_sigma_px;
  }
  return config;
}

Result<Done> WriteCalibratedConfig(const RobotConfig& config, const std::string& path) {
  const std::string temporary = path + ".new";
  std::ofstream file(temporary);
  file << WriteRobotConfig(config, ConfigText::kShort);
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(temporary, path, error);
  if (file && !error) return Done{};
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  return Error{ErrorCode::kIo,
               path + ": cannot be written" + (error ? ": " + error.message() : std::string())};
}

}  // namespace gw::camera

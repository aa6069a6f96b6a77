// Puts the calibration that the camera stores into the robot's YAML.
#pragma once

#include <string>

#include "common/config/robot_config.h"
#include "common/core/result.h"
#include "drivers/camera/protocol/calibration_table.h"

namespace gw::camera {

// Takes over the intrinsics of both eyes, the baseline, and for `kind: rgbd` the unit of depth. The
// rest stays as it is.
RobotConfig WithCalibration(RobotConfig config, const DepthCalibration& calibration);

// Writes the file anew, or not at all. Keys are commented by the reference; comments of people in a
// file that is overwritten are lost. Error kIo.
Result<Done> WriteCalibratedConfig(const RobotConfig& config, const std::string& path);

}  // namespace gw::camera

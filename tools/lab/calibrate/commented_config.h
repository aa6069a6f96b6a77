// A robot's YAML that says where its calibration comes from.
#pragma once

#include <string>

#include "common/config/robot_config.h"
#include "common/core/result.h"

namespace gw::calibrate {

// The configuration under a comment with what made it and what that found. Error: kIo.
Result<Done> WriteCommented(const std::string& file, const std::string& made_by,
                            const std::string& report, const RobotConfig& config);

}  // namespace gw::calibrate

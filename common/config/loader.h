// Reads a robot's YAML into a RobotConfig, strictly: a file that loads is complete, and every key
// in it has an effect.
//
// Refused, all in one go: unknown and duplicate keys, missing required keys and sections, values of
// the wrong type (1 is no bool, 1.5 no int, "1" no number), not finite, or out of range, enum
// values that do not exist, quaternions whose norm is off by more than 1e-3 (within, they are
// normalised), and the cross-field rules of validate.h.
#pragma once

#include <string>

#include "common/config/robot_config.h"
#include "common/core/result.h"

namespace gw {

// Error: kNotFound (no such file), kIo (cannot be read), kBadConfig. The message of kBadConfig
// holds one line for each mistake, sorted by line of the file:
//   FILE:LINE: KEY.PATH = VALUE: RULE, WHAT TO DO
Result<RobotConfig> LoadRobotConfig(const std::string& path);

// The same for text in memory; `name` stands for the file in messages.
Result<RobotConfig> ParseRobotConfig(const std::string& text, const std::string& name);

}  // namespace gw

// Writes a RobotConfig as YAML that LoadRobotConfig reads back to the same values, bit by bit.
#pragma once

#include <cstdint>
#include <string>

#include "common/config/robot_config.h"

namespace gw {

enum class ConfigText {
  kEffective,  // every key, so that the file shows what a program runs with
  kShort,      // required keys and those that differ from their default
};

// With a comment for each key: unit, range, meaning. An optional section that has required keys and
// was not given (the right eye of an RGB-D camera) is left out.
std::string WriteRobotConfig(const RobotConfig& config, ConfigText text = ConfigText::kEffective);

// Names a configuration in messages, reports and golden files: equal values give an equal hash,
// whatever the file looked like.
uint64_t ConfigHash(const RobotConfig& config);

}  // namespace gw

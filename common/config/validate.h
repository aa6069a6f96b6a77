// Rules that tie several fields of the configuration together. (Rules for one field stand in its
// FieldSpec.)
#pragma once

#include <string>
#include <vector>

#include "common/config/robot_config.h"

namespace gw {

struct RuleViolation {
  std::string key;   // full key path, "frontend.dr_weight.alpha_max"
  std::string rule;  // with the values and what to do
};

// Every rule that the configuration breaks. Fields are expected to be in their own ranges.
std::vector<RuleViolation> CheckRules(const RobotConfig& config);

}  // namespace gw

// The configuration as a tree of named texts: what the writer and the reference page are made from.
#pragma once

#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "common/core/fields.h"

namespace gw {

struct FieldInfo {
  std::string name;  // last part of the key
  std::string type;  // for people: "bool", "int", "float", "string", "5 floats", "enum", "pose"
  FieldSpec spec;
  std::string value;                 // as YAML; empty for a section
  std::vector<std::string> choices;  // enum only
  bool is_section = false;
  std::vector<FieldInfo> fields;  // section only, in order of declaration
};

// The root is a section without a name.
FieldInfo DescribeConfig(const RobotConfig& config);

}  // namespace gw

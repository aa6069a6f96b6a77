// What is wrong with a recording, for people.
#pragma once

#include <string>
#include <vector>

namespace gw::check {

enum class Severity {
  kError,    // SLAM on this recording cannot be trusted
  kWarning,  // it costs accuracy, or hides a fault
};

struct Finding {
  Severity severity = Severity::kWarning;
  std::string id;  // of the kind of fault, for scripts: "eyes-swapped"; docs/programs.md lists them
  std::string text;  // the number, and what it means
  std::string fix;   // what to do
};

using Findings = std::vector<Finding>;

}  // namespace gw::check

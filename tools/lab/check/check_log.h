// All checks of a recording.
#pragma once

#include <string>

#include "common/config/robot_config.h"
#include "common/core/result.h"
#include "tools/lab/check/finding.h"

namespace gw::check {

struct Report {
  std::string facts;  // what the recording holds, some lines for people
  Findings findings;  // errors first
};

// with_vision: also follows the images, which takes about as long as gw-slam. Errors: kNotFound,
// kIo, kBadConfig.
Result<Report> CheckLog(const std::string& log, const RobotConfig& config, bool with_vision);

// One page.
std::string ReportText(const Report& report);
// For scripts of the shell: severity, id, text and fix between tabs, one finding a line.
std::string ReportLines(const Report& report);
std::string ReportJson(const Report& report);

}  // namespace gw::check

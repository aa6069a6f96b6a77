// gw-check on what was just imported, so that nobody runs SLAM on a recording that is not sound.
#pragma once

#include <string>

#include "common/core/result.h"
#include "tools/data/files/json_fwd.h"

namespace gw::importer {

// Runs the gw-check beside this program, without following the images (seconds, not minutes).
// Returns its findings, a list of {severity, id, text, fix}. Errors: kNotFound where there is no
// such program, kIo when it fails; what it said.
Result<tools::Json> RunCheck(const std::string& log, const std::string& config);

// For people: a count, and each finding with what to do.
std::string CheckText(const tools::Json& findings, const std::string& log,
                      const std::string& config);

}  // namespace gw::importer

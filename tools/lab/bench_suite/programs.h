// The other programs of the project, run as children.
#pragma once

#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::bench {

// A program that was built together with this one. Error kNotFound: the path.
Result<std::string> SiblingProgram(const std::string& name);

// Runs a program to its end; what it prints goes to the file `output`. Error kIo when it cannot be
// started; kBadData, with the last line it printed, when it ends with anything but 0.
Result<Done> RunProgram(const std::vector<std::string>& command, const std::string& output);

}  // namespace gw::bench

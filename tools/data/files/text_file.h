// Whole text files.
#pragma once

#include <string>

#include "common/core/result.h"

namespace gw::tools {

// Error: kNotFound (cannot be opened) or kIo; the path and what the system says.
Result<std::string> ReadTextFile(const std::string& path);

// Replaces the file; its folder must be there. It has its name only when it is complete; until then
// it is PATH.part. Error kIo: the path and what the system says.
Result<Done> WriteTextFile(const std::string& path, const std::string& text);

}  // namespace gw::tools

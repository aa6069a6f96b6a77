// Reads and writes attributes of the kernel, which are files.
#pragma once

#include <filesystem>
#include <string>

#include "common/core/result.h"

namespace gw::camera {

// The first line of the file; empty when it cannot be read.
std::string ReadSysfs(const std::filesystem::path& file);
// The first line as a number; 0 when it is none.
int ReadSysfsNumber(const std::filesystem::path& file, int base = 10);
// Writes the value. Error kIo, whose text names the file and what to do.
Result<Done> WriteSysfs(const std::filesystem::path& file, const std::string& value);

}  // namespace gw::camera

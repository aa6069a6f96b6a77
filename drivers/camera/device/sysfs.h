// Attributes of the kernel as files.
#pragma once

#include <filesystem>
#include <string>

#include "common/core/result.h"

namespace gw::camera {

// The first line; empty when it cannot be read.
std::string ReadSysfs(const std::filesystem::path& file);
// As a number; 0 when it is none.
int ReadSysfsNumber(const std::filesystem::path& file, int base = 10);
// Error kIo, with the file and what to do.
Result<Done> WriteSysfs(const std::filesystem::path& file, const std::string& value);

}  // namespace gw::camera

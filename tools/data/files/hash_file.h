// Names a file by its bytes.
#pragma once

#include <cstdint>
#include <string>

#include "common/core/result.h"

namespace gw::tools {

// FNV-1a of the bytes. Error: kNotFound, kIo.
Result<uint64_t> HashFile(const std::string& path);

// 16 hexadecimal digits, as in reports.
std::string HashText(uint64_t hash);

}  // namespace gw::tools

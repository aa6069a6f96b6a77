// Files that are there as a whole or not at all, also after a power failure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::grid {

// Replaces what is there. Error kIo: the path, what the system says.
Result<Done> WriteWholeFile(const std::string& path, std::span<const uint8_t> bytes);

// Errors: kNotFound, kIo.
Result<std::vector<uint8_t>> ReadWholeFile(const std::string& path);

}  // namespace gw::grid

// JSON that the tools write and read.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/data/files/json_fwd.h"

namespace gw::tools {

// On one line, without blanks. Bytes of a name that are no UTF-8 become U+FFFD, and numbers that
// are not finite become null, because JSON has neither.
std::string JsonLine(const Json& value);

// The same over several lines, indented by two blanks.
std::string JsonDocument(const Json& value);

template <typename T>
Json ValueOrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace gw::tools

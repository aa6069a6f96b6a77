// JSON that the tools write and read. Keys keep the order in which they were added, so that equal
// values are equal bytes.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace gw::tools {

using Json = nlohmann::ordered_json;

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

// The name of the tools' JSON, for headers that only pass it on: its library is long to compile.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace gw::tools {

// Keys keep the order in which they were added, so that equal values are equal bytes.
using Json = nlohmann::ordered_json;

}  // namespace gw::tools

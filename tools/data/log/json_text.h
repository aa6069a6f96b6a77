// The little JSON that the log tools print.
#pragma once

#include <string>
#include <string_view>

namespace gw::tools {

// A JSON string with its quotes; control characters are escaped, UTF-8 passes through.
std::string JsonQuote(std::string_view text);

}  // namespace gw::tools

// Numbers as text, the same on every machine and in every locale.
#pragma once

#include <string>

namespace gw {

// Shortest decimal text that reads back as the same double.
std::string FormatDouble(double value);

// With this many decimals. Never "-0.00".
std::string FormatFixed(double value, int decimals);

}  // namespace gw

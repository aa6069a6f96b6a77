#include "common/core/format.h"

#include <charconv>
#include <cmath>

namespace gw {

std::string FormatDouble(double value) {
  char buffer[32];
  const double size = std::abs(value);
  const bool plain = value == 0 || (size >= 1e-4 && size < 1e7);
  const auto format = plain ? std::chars_format::fixed : std::chars_format::scientific;
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value, format).ptr;
  return std::string(buffer, end);
}

std::string FormatFixed(double value, int decimals) {
  char buffer[384];  // the largest double has 309 digits before the point
  const auto [end, error] =
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::fixed, decimals);
  if (error != std::errc()) return FormatDouble(value);
  std::string text(buffer, end);
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

}  // namespace gw

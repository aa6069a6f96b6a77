// Text from values, by the format strings of printf; types are taken from the values.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::tools {

// A value to be formatted. It refers to text and does not keep it.
using FormatValue = std::variant<int, unsigned, long, unsigned long, long long, unsigned long long,
                                 double, char, std::string_view>;

std::string FormatValues(const char* format, std::initializer_list<FormatValue> values);

template <typename... Values>
std::string Format(const char* format, const Values&... values) {
  return FormatValues(format, {FormatValue(values)...});
}

// A line of a trajectory file: t tx ty tz qx qy qz qw; s, m.
std::string TumLine(Utime utime, const SE3& T);

}  // namespace gw::tools

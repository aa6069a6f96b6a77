// A numeric constant that one run may halve or double. instrument.py puts this header into a COPY
// of the tree; nothing of the product includes it.
//
// The environment variable GW_OVERRIDE is `path:kName=DIRECTION`. Directions: `half`, `double`, and
// for shares, ratios and cosines near one `more` and `less`, which halve and double what is missing
// to one. Whole numbers are rounded down. The new value goes to stderr.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <type_traits>

#include "common/core/time.h"

namespace gw::override_value {

inline double Apply(const std::string& direction, double value) {
  if (direction == "half") return value / 2;
  if (direction == "double") return value * 2;
  if (direction == "more") return 1 - (1 - value) / 2;
  if (direction == "less") return 1 - (1 - value) * 2;
  std::fprintf(stderr, "override: unknown direction %s\n", direction.c_str());
  std::exit(2);
}

template <typename T>
T Of(const char* id, T value) {
  const char* wanted = std::getenv("GW_OVERRIDE");
  const size_t length = std::strlen(id);
  if (wanted == nullptr || std::strncmp(wanted, id, length) != 0 || wanted[length] != '=') {
    return value;
  }
  const std::string direction = wanted + length + 1;
  double before = 0;
  double after = 0;
  if constexpr (std::is_same_v<T, DurationUs>) {
    before = static_cast<double>(value.us) * 1e-3;
    value.us = static_cast<int64_t>(Apply(direction, static_cast<double>(value.us)));
    after = static_cast<double>(value.us) * 1e-3;
  } else {
    before = static_cast<double>(value);
    value = static_cast<T>(Apply(direction, before));
    after = static_cast<double>(value);
  }
  std::fprintf(stderr, "override: %s %.9g %.9g\n", id, before, after);
  return value;
}

}  // namespace gw::override_value

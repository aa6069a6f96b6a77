// A numeric constant that one run may halve or double. instrument.py puts this header into a COPY
// of the tree; nothing of the product includes it.
//
// The environment variable GW_OVERRIDE is `path:kName=DIRECTION`, or several of them with commas.
// Directions: `half`, `double`, and for shares, ratios and cosines near one `more` and `less`,
// which halve and double what is missing to one; or a number, the new value. Whole numbers are
// rounded down. The new values go to stderr.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <type_traits>

#include "common/core/time.h"

namespace gw::override_value {

inline double Apply(const std::string& direction, double value) {
  if (direction == "half") return value / 2;
  if (direction == "double") return value * 2;
  if (direction == "more") return 1 - (1 - value) / 2;
  if (direction == "less") return 1 - (1 - value) * 2;
  char* end = nullptr;
  const double given = std::strtod(direction.c_str(), &end);
  if (end != direction.c_str() && *end == '\0') return given;
  std::fprintf(stderr, "override: unknown direction %s\n", direction.c_str());
  std::exit(2);
}

// Empty when this constant stays as it is.
inline std::string DirectionOf(const std::string& id) {
  const char* const set = std::getenv("GW_OVERRIDE");
  if (set == nullptr) return "";
  std::string wanted(1, ',');  // no operator+: gcc 12 warns of it wrongly (-Wrestrict)
  wanted.append(set).append(1, ',');
  const size_t found = wanted.find(std::string(1, ',').append(id).append(1, '='));
  if (found == std::string::npos) return "";
  const size_t begin = found + id.size() + 2;
  return wanted.substr(begin, wanted.find(',', begin) - begin);
}

template <typename T>
T Of(const char* id, T value) {
  const std::string direction = DirectionOf(id);
  if (direction.empty()) return value;
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

// Time of the project: 64-bit integer microseconds. Only drivers and process shells read a clock;
// everything else takes its time from the samples it is given.
#pragma once

#include <compare>
#include <cstdint>

namespace gw {

// A length of time.
struct DurationUs {
  int64_t us = 0;
  constexpr double seconds() const { return static_cast<double>(us) * 1e-6; }
  constexpr auto operator<=>(const DurationUs&) const = default;
  constexpr DurationUs operator-() const { return {-us}; }
  constexpr DurationUs operator+(DurationUs other) const { return {us + other.us}; }
  constexpr DurationUs operator-(DurationUs other) const { return {us - other.us}; }
};

// An instant of measurement, microseconds since the epoch of the robot's clock (a recording keeps
// the epoch of its source). Negative and zero are valid but unusual.
struct Utime {
  int64_t us = 0;
  constexpr double seconds() const { return static_cast<double>(us) * 1e-6; }
  constexpr auto operator<=>(const Utime&) const = default;
  constexpr DurationUs operator-(Utime other) const { return {us - other.us}; }
  constexpr Utime operator+(DurationUs d) const { return {us + d.us}; }
  constexpr Utime operator-(DurationUs d) const { return {us - d.us}; }
};

constexpr DurationUs Milliseconds(int64_t ms) {
  return {ms * 1000};
}

// Rounds to the nearest microsecond. Precondition: |s| < 9.2e12.
constexpr DurationUs DurationFromSeconds(double s) {
  const double us = s * 1e6;
  return {static_cast<int64_t>(us + (us >= 0 ? 0.5 : -0.5))};
}
constexpr Utime UtimeFromSeconds(double s) {
  return {DurationFromSeconds(s).us};
}

}  // namespace gw

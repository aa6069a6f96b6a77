// Turns encoder ticks and the base's heading into motion of the body.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/camera/calibration.h"

namespace gw::kobuki {

struct WheelTicks {
  uint16_t left = 0, right = 0;
};

struct PlanarMotion {
  double dx_m = 0, dy_m = 0, dyaw_rad = 0;  // in B as it was at the begin
};

// The motion when both wheels rolled without slip at constant speeds. Either difference of ticks
// must be below half a turn of the counter, 2.79 m.
inline PlanarMotion MotionBetween(WheelTicks before, WheelTicks after,
                                  const WheelCalibration& wheel) {
  const auto metres = [&wheel](uint16_t from, uint16_t to) {
    return static_cast<int16_t>(static_cast<uint16_t>(to - from)) / wheel.ticks_per_metre;
  };
  const double left = metres(before.left, after.left);
  const double right = metres(before.right, after.right);
  const double way = (left + right) / 2;
  const double yaw = (right - left) / wheel.track_width_m;
  // The way is an arc: its chord points half the turn aside, and is shorter by the factor sin(h) /
  // h.
  const double half = yaw / 2;
  const double chord = std::abs(half) < 1e-6 ? way : way * std::sin(half) / half;
  return {chord * std::cos(half), chord * std::sin(half), yaw};
}

// The firmware's heading in radians, in [-pi, pi]. Whole turns of the count of 0.01 degrees vanish,
// whatever the firmware wraps at.
inline double HeadingFromCentidegrees(int16_t angle_cdeg) {
  const int wrapped = ((angle_cdeg + 18000) % 36000 + 36000) % 36000 - 18000;
  return wrapped * (std::numbers::pi / 18000);
}

}  // namespace gw::kobuki

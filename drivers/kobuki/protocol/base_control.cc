#include "drivers/kobuki/protocol/base_control.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gw::kobuki {
namespace {

// M/s and rad/s below which a speed counts as zero, as in the kobuki_core package.
constexpr double kSmall = 1e-4;

// Rounds to the nearest whole number, halfway values toward zero, so that rounding never makes the
// robot faster.
int16_t ToInt16(double value) {
  constexpr double kMax = std::numeric_limits<int16_t>::max();
  const double magnitude = std::min(std::ceil(std::abs(value) - 0.5), kMax);
  return static_cast<int16_t>(std::copysign(magnitude, value));
}

}  // namespace

BaseControl MakeBaseControl(const Twist& twist, double track_m) {
  if (!std::isfinite(twist.v_m_s) || !std::isfinite(twist.w_rad_s)) return {};
  constexpr double kMaxRadius = std::numeric_limits<int16_t>::max();
  const double b = 1000 * track_m;
  const double v = 1000 * twist.v_m_s;
  const double w = twist.w_rad_s;
  // A turn wider than the wire can tell becomes whichever is nearer: straight, or the widest turn.
  if (std::abs(w) < kSmall || std::abs(v) > 2 * kMaxRadius * std::abs(w)) return {ToInt16(v), 0};
  double radius = v / w;
  if (std::abs(twist.v_m_s) < kSmall || std::abs(radius) <= 1) return {ToInt16(b * w / 2), 1};
  const double turn = std::abs(radius) > kMaxRadius ? v / std::copysign(kMaxRadius, radius) : w;
  // A radius of 1 would mean turning in place.
  const double whole = std::clamp(std::round(std::abs(radius)), 2.0, kMaxRadius);
  radius = std::copysign(whole, radius);
  return {ToInt16((radius + std::copysign(b / 2, radius)) * turn), static_cast<int16_t>(radius)};
}

Twist ToTwist(const BaseControl& control, double track_m) {
  const double speed = control.speed_mm_s * 1e-3;
  if (control.radius_mm == 0) return {speed, 0};
  if (control.radius_mm == 1) return {0, 2 * speed / track_m};
  const double radius = control.radius_mm * 1e-3;
  const double w = speed / (radius + std::copysign(track_m / 2, radius));
  return {w * radius, w};
}

}  // namespace gw::kobuki

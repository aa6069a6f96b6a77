#include "drivers/kobuki/core/command_shaper.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace gw::kobuki {
namespace {

// A step that is longer than this, because the process was stalled, does not move the ramp further.
constexpr double kMaxStepS = 0.1;

double Ramp(double current, double target, double up, double down) {
  // A change of sign takes two strokes: first slower to zero, then faster the other way.
  if (current * target < 0) target = 0;
  const double limit = std::abs(target) > std::abs(current) ? up : down;
  return current + std::clamp(target - current, -limit, limit);
}

}  // namespace

bool CommandShaper::Push(const BaseCommand& command, Utime now) {
  if (!std::isfinite(command.v_m_s) || !std::isfinite(command.w_rad_s)) return false;
  const DurationUs age = now - command.utime;
  const DurationUs timeout = Milliseconds(config_.command_timeout_ms);
  if (age > timeout || age < -timeout) return false;
  command_ = command;
  received_ = now;
  return true;
}

bool CommandShaper::commanded(Utime now) const {
  return received_ && now - *received_ <= Milliseconds(config_.command_timeout_ms);
}

Twist CommandShaper::Wanted(Utime now) const {
  if (!commanded(now)) return {};
  const double max_w = config_.max_turn_deg_s * (std::numbers::pi / 180);
  // Both speeds are scaled alike, so that a command that is too fast still drives its curve.
  const double excess = std::max(
      {1.0, std::abs(command_.v_m_s) / config_.max_speed_m_s, std::abs(command_.w_rad_s) / max_w});
  return {command_.v_m_s / excess, command_.w_rad_s / excess};
}

Twist CommandShaper::Step(const Twist& target, Utime now) {
  const double dt = stepped_ ? std::clamp((now - *stepped_).seconds(), 0.0, kMaxStepS) : 0.0;
  stepped_ = now;
  current_.v_m_s =
      Ramp(current_.v_m_s, target.v_m_s, config_.accel_m_s2 * dt, config_.decel_m_s2 * dt);
  current_.w_rad_s = Ramp(current_.w_rad_s, target.w_rad_s, config_.turn_accel_rad_s2 * dt,
                          config_.turn_decel_rad_s2 * dt);
  return current_;
}

}  // namespace gw::kobuki

#include "tools/robot/floorplan/pursuit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gw::floorplan {
namespace {

using Eigen::Vector2d;

constexpr double kTurnGain = 1.5;       // 1/s
constexpr double kAheadTooFar = 1.2;    // rad off the way ahead: turn on the spot,
constexpr double kAheadEnough = 0.15;   // until this
constexpr double kCarriedAway = 1.0;    // m from the leg: join it where it is nearest
constexpr size_t kSearchPoints = 40;    // of the leg, ahead
constexpr double kSlowInCurves = 0.8;   // m: speed is divided by 1 + this * curvature
constexpr double kCreep = 0.08;         // m/s at the very end
constexpr double kApproachGain = 0.9;   // 1/s
constexpr double kShortestAhead = 0.1;  // m, that a curvature is computed with
constexpr double kLeastAhead = 0.2;     // m, of what it looks ahead when it drives slowly

}  // namespace

double AngleTo(double from, double to) {
  return std::remainder(to - from, 2 * std::numbers::pi);
}

Speed TurnBy(double error, double max_w) {
  return {0, std::clamp(kTurnGain * error, -max_w, max_w)};
}

Speed Pursuit::Update(const Vector2d& position, double yaw, double share) {
  const auto squared_distance = [&](size_t i) { return (leg_[i] - position).squaredNorm(); };
  // The nearest point of the leg, searched ahead only: ways may cross themselves.
  for (size_t i = nearest_; i < std::min(leg_.size(), nearest_ + kSearchPoints); ++i) {
    if (squared_distance(i) < squared_distance(nearest_)) nearest_ = i;
  }
  if ((leg_[nearest_] - position).norm() > kCarriedAway) {
    for (size_t i = 0; i < leg_.size(); ++i) {
      if (squared_distance(i) < squared_distance(nearest_)) nearest_ = i;
    }
  }
  size_t target = nearest_;
  const double look_ahead = std::max(share * config_.look_ahead_m, kLeastAhead);
  while (target + 1 < leg_.size() && (leg_[target] - position).norm() < look_ahead) {
    ++target;
  }
  const Vector2d ahead = leg_[target] - position;
  const double bearing = AngleTo(yaw, std::atan2(ahead.y(), ahead.x()));
  if (turning_ || std::abs(bearing) > kAheadTooFar) {
    turning_ = std::abs(bearing) > kAheadEnough;
    return TurnBy(bearing, config_.max_w);
  }
  const double curvature = 2 * std::sin(bearing) / std::max(kShortestAhead, ahead.norm());
  double v = share * config_.max_v / (1 + kSlowInCurves * std::abs(curvature));
  v = std::min(v, kCreep + kApproachGain * DistanceToEnd(position));
  double w = v * curvature;
  if (std::abs(w) > config_.max_w) {
    v *= config_.max_w / std::abs(w);
    w = std::copysign(config_.max_w, w);
  }
  return {v, w};
}

}  // namespace gw::floorplan

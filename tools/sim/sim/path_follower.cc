#include "tools/sim/sim/path_follower.h"

#include <cmath>
#include <utility>

namespace gw::sim {
namespace {

constexpr double kArrived = 0.08;  // m
constexpr double kAligned = 0.05;  // rad

}  // namespace

PathFollower::PathFollower(std::vector<floorplan::Waypoint> stops,
                           const std::vector<floorplan::Leg>& legs, const FollowerConfig& config)
    : stops_(std::move(stops)), config_(config) {
  for (const floorplan::Leg& leg : legs) legs_.emplace_back(leg, config.pursuit);
}

floorplan::Speed PathFollower::Update(double time_s, const Eigen::Vector2d& position, double yaw) {
  if (finished() || (pause_until_ && time_s < *pause_until_)) return {};
  if (pause_until_) {
    pause_until_.reset();
    arrived_ = false;
    ++leg_;
    if (finished()) return {};
  }
  floorplan::Pursuit& leg = legs_[leg_];
  arrived_ = arrived_ || leg.DistanceToEnd(position) < kArrived;
  if (!arrived_) return leg.Update(position, yaw);
  const double error = floorplan::AngleTo(yaw, stops_[leg_ + 1].yaw);
  if (config_.turn_at_waypoints && std::abs(error) >= kAligned) {
    return floorplan::TurnBy(error, config_.pursuit.max_w);
  }
  pause_until_ = time_s + config_.pause_s;
  return {};
}

}  // namespace gw::sim

// Drives the way through the stops on ground truth: what `gw-sim --drive path` does.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tools/robot/floorplan/pursuit.h"

namespace gw::sim {

struct FollowerConfig {
  floorplan::PursuitConfig pursuit;
  bool turn_at_waypoints = true;  // to the waypoint's heading, before going on
  double pause_s = 0.5;           // at each waypoint
};

class PathFollower {
 public:
  // legs: from each stop to the next.
  PathFollower(std::vector<floorplan::Waypoint> stops, const std::vector<floorplan::Leg>& legs,
               const FollowerConfig& config);

  // Pose at time_s; call at a fixed rate.
  floorplan::Speed Update(double time_s, const Eigen::Vector2d& position, double yaw);
  int legs_done() const { return leg_; }
  bool finished() const { return leg_ >= static_cast<int>(legs_.size()); }

 private:
  std::vector<floorplan::Waypoint> stops_;
  std::vector<floorplan::Pursuit> legs_;
  FollowerConfig config_;
  int leg_ = 0;
  bool arrived_ = false;  // at the end of the leg, turning to the waypoint's heading
  std::optional<double> pause_until_;
};

}  // namespace gw::sim

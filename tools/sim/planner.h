// Plans and follows a way through waypoints, on ground truth: what `gw-sim --drive path` does.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/sim/floor_map.h"

namespace gw::sim {

struct Waypoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

// The way from one waypoint to the next, points 5 cm apart.
using Leg = std::vector<Eigen::Vector2d>;

// Moves stops that are nearer to a wall than the robot can stand to the nearest place where it can,
// by up to kMaxStopMove: maps drawn by people have such stops, and a waypoint counts as reached at
// 0.2 m. Stops that need a longer move stay as they are.
inline constexpr double kMaxStopMove = 0.3;  // m
std::vector<Waypoint> MoveStopsFromWalls(const FloorMap& map, std::vector<Waypoint> stops,
                                         double clearance);

// One leg for each waypoint of `visit` but the first: shortest ways that prefer room on both sides
// (A*), smoothed, at least `clearance` metres from walls. Error kBadData names the waypoint that
// lies outside the map, in or too near to a wall, or cannot be reached.
Result<std::vector<Leg>> PlanLegs(const FloorMap& map, const std::vector<Waypoint>& visit,
                                  double clearance);

// Reads `index x y theta` lines (# starts a comment), in order of index from 0, and a list of
// indices, one a line. Error kNotFound or kBadData with the line.
Result<std::vector<Waypoint>> LoadWaypoints(const std::string& path);
Result<std::vector<int>> LoadVisitOrder(const std::string& path, int num_waypoints);

struct FollowerConfig {
  double max_v = 0.5;   // m/s
  double max_w = 1.05;  // rad/s
  double look_ahead_m = 0.45;
  bool turn_at_waypoints = true;  // to the waypoint's heading, before going on
  double pause_s = 0.5;           // at each waypoint
};

// Pure pursuit (Coulter, CMU-RI-TR-92-01) with turns on the spot where the way leaves sideways.
class PathFollower {
 public:
  PathFollower(std::vector<Waypoint> visit, std::vector<Leg> legs, const FollowerConfig& config);

  struct Output {
    double v = 0, w = 0;
    bool finished = false;
  };
  // Pose at time_s; call at a fixed rate.
  Output Update(double time_s, const Eigen::Vector2d& position, double yaw);
  int legs_done() const { return leg_; }

 private:
  std::vector<Waypoint> visit_;
  std::vector<Leg> legs_;
  FollowerConfig config_;
  int leg_ = 0;
  size_t nearest_ = 0;
  bool turning_ = true;   // on the spot, before a leg
  bool arrived_ = false;  // at the end of the leg, turning to the waypoint's heading
  std::optional<double> pause_until_;
};

}  // namespace gw::sim

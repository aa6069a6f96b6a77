// Plans ways through waypoints around the obstacles of a floor map.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::floorplan {

// The way from one waypoint to the next, points kLegSpacing apart.
inline constexpr double kLegSpacing = 0.05;  // m
using Leg = std::vector<Eigen::Vector2d>;

// Moves stops that are nearer to a wall or to unknown cells than the robot can stand to the nearest
// place where it can, by up to kMaxStopMove: maps drawn by people have such stops, and a waypoint
// counts as reached at 0.2 m. Stops that need a longer move stay as they are.
inline constexpr double kMaxStopMove = 0.3;  // m
std::vector<Waypoint> MoveStopsFromWalls(const FloorMap& map, std::vector<Waypoint> stops,
                                         double clearance);

struct RefusedStop {
  int stop = 0;     // its index
  std::string why;  // a sentence that begins with the place
};

// A way through those stops that can be visited.
struct Tour {
  std::vector<int> visited;          // indices of stops, in their order
  std::vector<Leg> legs;             // from each of the visited to the next
  std::vector<RefusedStop> refused;  // all others
};

// Shortest ways that prefer room on both sides (A*), smoothed, at least `clearance` metres from
// walls and from unknown cells. Refused is a stop that lies outside the map, in or too near to a
// wall or to unknown cells, or that cannot be reached from the last one that is visited.
Tour PlanTour(const FloorMap& map, const std::vector<Waypoint>& stops, double clearance);

// One leg for each waypoint of `visit` but the first. Error kBadData: every one that is refused.
Result<std::vector<Leg>> PlanLegs(const FloorMap& map, const std::vector<Waypoint>& visit,
                                  double clearance);

}  // namespace gw::floorplan

// Plans ways through waypoints around the obstacles of a floor map.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/core/result.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::floorplan {

// The way from one waypoint to the next, points kLegSpacing apart.
inline constexpr double kLegSpacing = 0.05;  // m
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

}  // namespace gw::floorplan

// Places for boxes that the map does not have, for tests of what drives: on the way of a tour, so
// that it has to go around them, and can.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::floorplan {

// Up to `count` centres of square boxes of side `side` (m), each on the way that PlanLegs makes of
// the stops, no nearer than 0.8 m to a stop and 1.5 m to another box. With all of them every stop
// can still be visited. Fewer where the map has no room for them. Same seed, same places.
std::vector<Eigen::Vector2d> PlacesInTheWay(const FloorMap& map, const std::vector<Waypoint>& stops,
                                            double clearance, double side, int count,
                                            uint64_t seed);

// The map with a square box.
FloorMap WithBox(FloorMap map, const Eigen::Vector2d& centre, double side);

}  // namespace gw::floorplan

// How far it is to every place where a robot can stand.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"

namespace gw::explore {

// Length (m) of the shortest way over cells whose centres keep `clearance` m from cells that are
// not free, for every cell of the map; infinity where there is none. A robot that stands nearer to
// something begins at the nearest such cell, as the planner does (floorplan/planner.h).
std::vector<float> WayLengths(const floorplan::FloorMap& map, const Eigen::Vector2d& from,
                              double clearance);

}  // namespace gw::explore

// The floor around a robot that has looked around where it was put down: nearer than its camera
// sees, and farther than it covers itself.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"

namespace gw::explore {

// Centres of unknown cells within ring_m of the robot that may be taken for free: over them, floor
// is seen behind. What stood there high enough to hide that floor would have been seen; what is
// lower the bumper finds. A direction in which an obstacle or nothing is seen stays as it is.
std::vector<Eigen::Vector2d> FreeByLookingOver(const floorplan::FloorMap& map,
                                               const Eigen::Vector2d& robot, double ring_m);

}  // namespace gw::explore

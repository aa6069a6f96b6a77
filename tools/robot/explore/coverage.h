// How much of a building a floor map shows.
#pragma once

#include <Eigen/Core>

#include "common/core/se3.h"
#include "tools/robot/floorplan/floor_map.h"

namespace gw::explore {

struct Coverage {
  double reachable_m2 = 0;  // of the plan: floor that the robot can cover from where it began
  double seen_m2 = 0;       // of it: free on the robot's own floor map
};

// plan: what is there. own: what the robot knows, in M; T_MG: the plan's frame in it. start: where
// the robot began, on the plan.
Coverage CoverageOf(const floorplan::FloorMap& plan, const Eigen::Vector2d& start,
                    double robot_radius_m, const floorplan::FloorMap& own, const SE3& T_MG);

}  // namespace gw::explore

// Frontiers of a floor map: where known free floor ends and something is to be seen beyond
// (Yamauchi, "A frontier-based approach for autonomous exploration", CIRA 1997).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/robot/explore/unseen_floor.h"

namespace gw::explore {

struct Frontier {
  std::vector<int> cells;  // free cells beside open ones, 8-connected, ascending
  Eigen::Vector2d middle;  // centre of the cell that is nearest to their mean, m
};

// In the order of their first cells. Frontiers that are shorter than the robot is wide are left
// out: what is behind one through which it would not fit is not worth a look of its own.
std::vector<Frontier> FindFrontiers(const UnseenFloor& floor);

}  // namespace gw::explore

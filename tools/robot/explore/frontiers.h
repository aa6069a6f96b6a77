// Frontiers of a floor map: where known free floor ends and nothing is known beyond (Yamauchi,
// "A frontier-based approach for autonomous exploration", CIRA 1997).
//
// Between seen floor and an obstacle a floor map keeps a seam of unknown cells (ADR 37). Unknown
// cells nearer than kSeamM to an occupied one are that seam, and no frontier; so is a gap between
// two obstacles that is narrower than twice the seam.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"

namespace gw::explore {

inline constexpr double kSeamM = 0.15;

// 1 for every cell of the map that is unknown and no seam.
std::vector<uint8_t> OpenCells(const floorplan::FloorMap& map);

struct Frontier {
  std::vector<int> cells;  // free cells beside open ones, 8-connected, ascending
  Eigen::Vector2d middle;  // centre of the cell that is nearest to their mean, m
};

// In the order of their first cells. Frontiers shorter than least_m are left out: what is behind
// one through which the robot would not fit is not worth a look of its own. given_up: cells that
// are no frontier whatever lies beside them; empty: none.
std::vector<Frontier> FindFrontiers(const floorplan::FloorMap& map,
                                    const std::vector<uint8_t>& given_up, double least_m);

}  // namespace gw::explore

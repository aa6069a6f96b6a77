// What one scan says of the cells of a grid.
#pragma once

#include <vector>

#include "grid/core/cell_tiles.h"
#include "grid/core/floor_scan.h"
#include "grid/core/pose2.h"

namespace gw::grid {

struct CellEvidence {
  Index2 index;
  Cell cell;
};

// T_LB: the body in the frame of the grid. footprint_m: radius of the robot; where it stands is
// free. Every cell occurs once, in order of (y, x); a cell with a hit is not free.
std::vector<CellEvidence> EvidenceOf(const FloorScan& scan, const Pose2& T_LB, double cell_m,
                                     double footprint_m);

}  // namespace gw::grid

// What one scan says of the cells of a grid.
#pragma once

#include <vector>

#include "grid/core/cell_tiles.h"
#include "grid/core/floor_scan.h"
#include "grid/core/pose2.h"

namespace gw::grid {

// Log-odds of one look at a cell, and the bounds of their sum: what has been confirmed often still
// changes its mind after a few looks. Hornung et al., "OctoMap", Autonomous Robots 2013, section
// 5.1: P(hit) 0.7, P(miss) 0.4, bounds 0.12 and 0.97.
inline constexpr float kHit = 0.85f;
inline constexpr float kMiss = -0.4f;
inline constexpr float kLeastSum = -2.0f;
inline constexpr float kMostSum = 3.5f;

struct CellEvidence {
  Index2 cell;
  float log_odds = 0;
};

// T_LB: the body in the frame of the grid. footprint_m: radius of the robot; where it stands is
// free. Every cell occurs once, in order of (y, x); a cell with a hit is not free.
std::vector<CellEvidence> EvidenceOf(const FloorScan& scan, const Pose2& T_LB, double cell_m,
                                     double footprint_m);

}  // namespace gw::grid

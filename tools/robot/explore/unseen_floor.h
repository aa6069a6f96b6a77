// What of a floor map is still to be seen: unknown cells that may be floor that the robot could
// cover, and from how near they were looked at in vain.
//
// Not to be seen are unknown cells
//  - nearer than kSeamM to an occupied one: between seen floor and an obstacle a floor map keeps a
//    seam of unknown cells (ADR 37);
//  - that the robot could cover nowhere, even if all that is unknown were free;
//  - that were looked at in vain from so near that no nearer look is possible (vain_looks.h);
//  - in a region of such cells that is smaller than the robot: it drives around it.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "tools/robot/explore/sight.h"
#include "tools/robot/floorplan/floor_map.h"

namespace gw::explore {

inline constexpr double kSeamM = 0.15;
// A look at what was looked at in vain is expected to show it from this part of the range only.
inline constexpr double kNearer = 0.5;
inline constexpr float kNeverLookedAt = std::numeric_limits<float>::infinity();

struct UnseenFloor {
  floorplan::FloorMap map;         // may take open cells for free
  std::vector<uint8_t> open;       // 1 for every cell that is to be seen
  std::vector<float> looked_at_m;  // for every cell: the least range of a look in vain
  Sight sight;
  double robot_radius_m = 0;

  // May a look over `range` m show the cell?
  bool MayShow(int cell, double range) const {
    return range < sight.max_range_m && range < kNearer * static_cast<double>(looked_at_m[cell]);
  }
};

// looked_at_m: VainLooks::On the map; empty: nothing was.
UnseenFloor FindUnseenFloor(floorplan::FloorMap map, std::vector<float> looked_at_m,
                            const Sight& sight, double robot_radius_m);

}  // namespace gw::explore

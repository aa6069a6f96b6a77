// How often frontiers were looked at in vain: from a place from which what lies beyond should have
// been seen, and was not (glass, a floor without texture, the shadow of a thing). The next look is
// from half as far; after kMostLooks the cell is no frontier any more.
//
// Counted by cell of W. A correction of the map that moves floor by more than a cell moves it from
// under its counts: it is looked at again then, as new floor is.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "tools/robot/explore/frontiers.h"
#include "tools/robot/explore/sight.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::explore {

inline constexpr uint8_t kMostLooks = 2;

// m: so near a look must be to show what lies beyond a cell that was looked at so often in vain;
// 0: it is given up.
double RangeLeft(const Sight& sight, uint8_t looks);

class LookCounts {
 public:
  // The robot has stood there and looked, and this is the floor map that came of it.
  void Add(const floorplan::FloorMap& map, const floorplan::Waypoint& place, const Sight& sight,
           double least_m);

  // For every cell of the map: how often it was looked at in vain.
  std::vector<uint8_t> On(const floorplan::FloorMap& map) const;

 private:
  std::map<std::pair<int, int>, uint8_t> counts_;  // by y, x of the cell in W
};

// 1 where looks are at their most.
std::vector<uint8_t> GivenUp(const std::vector<uint8_t>& looks);

}  // namespace gw::explore

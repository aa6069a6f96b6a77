// What a look from a place would show of a floor map, and which frontiers it looks past.
//
// A ray of sight goes over free floor, enters what is not known only where a frontier says that
// there is something to be seen, and ends at an obstacle, at the seam before one, or at the range.
// What lies in open cells counts as seen until something known is met again: nobody knows better.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/robot/explore/looks.h"
#include "tools/robot/explore/sight.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::explore {

class SightRays {
 public:
  // map, open (OpenCells) and looks (LookCounts::On) must outlive it.
  SightRays(const floorplan::FloorMap& map, const std::vector<uint8_t>& open,
            const std::vector<uint8_t>& looks, const Sight& sight)
      : map_(map), open_(open), looks_(looks), sight_(sight) {}

  // Area of open cells, m^2, that a look from there would show.
  double UnseenFrom(const floorplan::Waypoint& place) const;

  // Can a look from there be expected to show what lies beyond the frontier cell at `p`? It lies in
  // view over free floor, and within the range that is left after the looks that saw nothing there.
  bool LooksPast(const floorplan::Waypoint& place, const Eigen::Vector2d& p) const;

 private:
  enum class Kind { kFree, kOpen, kEnd };
  Kind KindOf(const Eigen::Vector2i& cell) const;

  const floorplan::FloorMap& map_;
  const std::vector<uint8_t>& open_;
  const std::vector<uint8_t>& looks_;
  Sight sight_;
};

}  // namespace gw::explore

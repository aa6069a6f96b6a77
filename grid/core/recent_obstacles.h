// What stands around the robot now: seen by the newest scan, or a while ago and since out of view.
//
// Kept in the odometry frame O, which never jumps, so that it does not depend on the map or on
// vision. One scan is enough to be an obstacle; a few scans that see the floor there take it away.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "common/config/grid_config.h"
#include "common/contract/grid.h"
#include "common/core/se3.h"
#include "grid/core/cell_tiles.h"
#include "grid/core/floor_scan.h"

namespace gw::grid {

class RecentObstacles {
 public:
  RecentObstacles(const GridConfig& config, double footprint_m)
      : config_(config), footprint_m_(footprint_m) {}

  // T_OB: of the scan's image; empty where dead reckoning does not know: then what was seen before
  // is forgotten, as it is when `odometry_epoch` changes (O began anew). seq is left 0.
  ObstacleView Push(Utime utime, const std::optional<SE3>& T_OB, uint32_t odometry_epoch,
                    const FloorScan& scan);

 private:
  struct Seen {
    float log_odds = 0;
    Utime utime;
  };

  GridConfig config_;
  double footprint_m_;
  std::map<Index2, Seen> cells_;  // in O; in B without dead reckoning
  std::optional<uint32_t> epoch_;
};

// So far the floor ahead of the robot, as wide as it is, is seen without an obstacle: m from B.
double SeenAhead(const FloorScan& scan, double half_width_m);

}  // namespace gw::grid

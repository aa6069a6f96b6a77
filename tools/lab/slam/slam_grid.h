// The floor map of a run of gw-slam: what gw-grid makes of the same images, poses and map updates.
#pragma once

#include <string>

#include "common/config/robot_config.h"
#include "grid/core/grid_map.h"
#include "grid/core/look_taker.h"
#include "tools/lab/slam/slam_session.h"

namespace gw::tools {

class SlamGrid {
 public:
  SlamGrid(const RobotConfig& config, const CameraGeometry& geometry);

  // Follows the session from here on; this object must outlive it. Call before the first event.
  void Follow(SlamSession* session);

  // map.yaml and map.pgm into `directory`. Errors: kBadData when nothing was seen, kIo.
  Result<Done> Write(const std::string& directory);
  // The local grids, beside a map on disk.
  Result<Done> Save(const std::string& map_directory) const;

  const grid::GridMapCounters& counters() const { return map_.counters(); }

 private:
  void Look(const CameraFrame& frame, const FramePose& pose);

  grid::LookTaker looks_;
  grid::GridMap map_;
};

}  // namespace gw::tools

#include "tools/lab/slam/slam_grid.h"

#include "grid/core/floor_image.h"
#include "grid/files/grid_file.h"
#include "grid/files/map_server.h"

namespace gw::tools {

SlamGrid::SlamGrid(const RobotConfig& config, const CameraGeometry& geometry)
    : looks_(geometry, config.grid),
      map_(config.grid, geometry.rectified.T_BC, config.navigate.robot_radius_m) {}

void SlamGrid::Follow(SlamSession* session) {
  session->WatchMapping(
      {[this](const CameraFrame& frame, const FramePose& pose) { Look(frame, pose); },
       [this](const MapUpdate& update) { map_.Apply(update); }});
}

void SlamGrid::Look(const CameraFrame& frame, const FramePose& pose) {
  if (!looks_.Due(frame.utime)) return;
  if (const auto scan = looks_.Look(frame, map_.length_factor())) map_.Add(pose, *scan);
  map_.Compose();
}

Result<Done> SlamGrid::Write(const std::string& directory) {
  map_.Compose();
  return grid::WriteMapServer(directory, grid::MakeFloorImage(map_.tiles(), map_.cell_m()));
}

Result<Done> SlamGrid::Save(const std::string& map_directory) const {
  return grid::SaveGrid(map_directory, {map_.cell_m(), map_.Save()});
}

}  // namespace gw::tools

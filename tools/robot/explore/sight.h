// What a robot sees of the floor when it stands and looks ahead: the floor's part of the camera's
// view, as a sector about the robot's centre.
#pragma once

#include "common/camera/camera_model.h"
#include "common/config/grid_config.h"
#include "common/core/result.h"

namespace gw::explore {

struct Sight {
  double half_angle = 0;   // rad, (0, pi/2): to either side of straight ahead
  double min_range_m = 0;  // from B: nearer floor lies below the camera's view
  double max_range_m = 0;  // to which floor is relied upon to be seen
};

// Error kBadConfig when the camera sees no floor between the two ranges.
Result<Sight> SightOf(const CameraGeometry& camera, const GridConfig& grid);

}  // namespace gw::explore

// For tests: a camera like a D435, 640 x 480.
#pragma once

#include "common/camera/camera_model.h"

namespace gw::frontend {

inline RectifiedCamera TestCamera(double depth_max_m) {
  RectifiedCamera c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 385;
  c.cx = 320;
  c.cy = 240;
  c.baseline_m = 0.05;
  c.depth_min_m = 0.25;
  c.depth_max_m = depth_max_m;
  return c;
}

}  // namespace gw::frontend

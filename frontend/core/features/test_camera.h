// For tests: a camera like a D435, 640 x 480; and depth cameras of any size.
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

// RGB-D, without distortion, the axis in the middle.
inline Calibration TestDepthCalibration(int width, int height, double focal_px) {
  Calibration c;
  c.camera.width = width;
  c.camera.height = height;
  c.camera.left = {
      .fx = focal_px, .fy = focal_px, .cx = width / 2.0, .cy = height / 2.0, .radtan = {}};
  c.camera.depth_unit_m = 0.001;
  c.camera.depth_min_m = 0.3;
  c.camera.depth_max_m = 8;
  return c;
}

}  // namespace gw::frontend

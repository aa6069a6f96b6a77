// The colour and depth camera of the TUM RGB-D recordings fr1, for tests and benchmarks. Numbers:
// the data set's own calibration; depth images are in units of 0.2 mm.
#pragma once

#include "common/camera/camera_model.h"

namespace gw::frontend {

inline CameraGeometry TumGeometry() {
  Calibration c;
  c.camera.kind = CameraKind::kRgbd;
  c.camera.width = 640;
  c.camera.height = 480;
  c.camera.left = {.fx = 517.3,
                   .fy = 516.5,
                   .cx = 318.6,
                   .cy = 255.3,
                   .radtan = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
  c.camera.depth_unit_m = 0.0002;
  return MakeCameraGeometry(c).value();
}

}  // namespace gw::frontend

// The camera as far as faults of vision need it.
#pragma once

#include "common/camera/calibration.h"

namespace gw::fault {

// What a fault has to know of the camera to draw what stands at a distance. The defaults are those
// of a RealSense D435 at 640 x 480 (data sheet: 50 mm, 1 mm per unit of depth).
struct CameraOptics {
  double fx_px = 385;
  double baseline_m = 0.05;
  double depth_unit_m = 0.001;
};

inline CameraOptics OpticsOf(const CameraCalibration& camera) {
  CameraOptics out;
  out.fx_px = camera.left.fx;
  out.depth_unit_m = camera.depth_unit_m;
  if (camera.kind == CameraKind::kStereo) out.baseline_m = camera.T_C0C1.translation().norm();
  return out;
}

}  // namespace gw::fault

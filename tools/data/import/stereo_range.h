// Which depths of a stereo pair are worth using.
#pragma once

#include "common/camera/calibration.h"

namespace gw::importer {

// Sets depth_max_m to 5 px of disparity, where half a pixel of matching error is a tenth of the
// depth, and depth_min_m to a quarter of the image width of disparity (not below 0.3 m). Needs
// width, left and T_C0C1.
void SetStereoRange(CameraCalibration& camera);

}  // namespace gw::importer

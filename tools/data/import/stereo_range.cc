#include "tools/data/import/stereo_range.h"

#include <algorithm>

namespace gw::importer {

void SetStereoRange(CameraCalibration& camera) {
  const double bf = camera.left.fx * camera.T_C0C1.translation().norm();
  camera.depth_min_m = std::max(0.3, bf / (0.25 * camera.width));
  camera.depth_max_m = std::max(bf / 5.0, 2.0 * camera.depth_min_m);
}

}  // namespace gw::importer

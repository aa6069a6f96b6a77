#include "tools/robot/explore/sight.h"

#include <algorithm>
#include <cmath>

namespace gw::explore {
namespace {

// Of grid.max_range_m: at the end of it a look shows one cell here and none there.
constexpr double kShareOfRange = 0.75;
constexpr double kShareOfAngle = 0.95;  // the last columns have no partner in the other eye

}  // namespace

Result<Sight> SightOf(const CameraGeometry& geometry, const GridConfig& grid) {
  const RectifiedCamera& camera = geometry.rectified;
  Sight sight;
  sight.half_angle = kShareOfAngle * std::min(std::atan(camera.cx / camera.fx),
                                              std::atan((camera.width - camera.cx) / camera.fx));
  sight.max_range_m = kShareOfRange * std::min(grid.max_range_m, camera.depth_max_m);
  const Eigen::Vector3d eye_B = camera.T_BC.translation();
  // Where the lowest row meets the floor, at both ends of it.
  for (const double u : {0.0, static_cast<double>(camera.width)}) {
    const Eigen::Vector3d ray_B = camera.T_BC.rotation() * camera.Unproject(u, camera.height, 1);
    if (ray_B.z() >= 0 || eye_B.z() <= 0) {
      return Error{ErrorCode::kBadConfig, "calibration.camera: the camera sees no floor"};
    }
    const Eigen::Vector3d floor_B = eye_B - ray_B * (eye_B.z() / ray_B.z());
    sight.min_range_m = std::max(sight.min_range_m, floor_B.head<2>().norm());
  }
  if (sight.min_range_m < sight.max_range_m) return sight;
  return Error{ErrorCode::kBadConfig,
               "calibration.camera: the camera sees no floor within the range of grid.max_range_m"};
}

}  // namespace gw::explore

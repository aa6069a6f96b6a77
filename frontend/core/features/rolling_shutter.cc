#include "frontend/core/features/rolling_shutter.h"

namespace gw::frontend {

void UndoRollingShutter(const RectifiedCamera& camera, double readout_s, const Eigen::Vector3d& w_C,
                        std::vector<Feature>* features) {
  for (Feature& f : *features) {
    // Seen dt after mid-exposure, by a camera turned by w * dt since.
    const double dt = (f.v / camera.height - 0.5) * readout_s;
    const Eigen::Vector3d p_C = ExpSO3(w_C * dt) * camera.Unproject(f.u, f.v, 1.0);
    if (p_C.z() < 0.1) continue;
    const Eigen::Vector2d uv = camera.Project(p_C);
    if (f.has_disparity()) f.u_right += static_cast<float>(uv.x() - f.u);
    f.u = static_cast<float>(uv.x());
    f.v = static_cast<float>(uv.y());
  }
}

}  // namespace gw::frontend

#include "frontend/core/features/rolling_shutter.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

// A camera that turns while its rows are read out sees each point at the row's own instant; undone,
// the points lie where they were at mid-exposure.
TEST(RollingShutter, TurningCameraIsUndone) {
  RectifiedCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 520;
  camera.cx = 320;
  camera.cy = 240;
  camera.baseline_m = 0.1;
  constexpr double kReadout = 0.026;
  for (int i = 0; i < 200; ++i) {
    CounterRng rng(1, 0, i);
    const Eigen::Vector3d w(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-2, 2));
    const Eigen::Vector3d p_C =
        camera.Unproject(rng.Uniform(60, 580), rng.Uniform(60, 420), rng.Uniform(1, 5));
    const Eigen::Vector2d truth = camera.Project(p_C);
    // The row at which the point is read out, by iteration: the row depends on the instant.
    Eigen::Vector2d seen = truth;
    for (int k = 0; k < 20; ++k) {
      const double dt = (seen.y() / camera.height - 0.5) * kReadout;
      seen = camera.Project(ExpSO3(-w * dt) * p_C);
    }
    Feature f;
    f.u = static_cast<float>(seen.x());
    f.v = static_cast<float>(seen.y());
    f.depth = static_cast<float>(p_C.z());
    f.u_right = f.u - static_cast<float>(camera.bf() / p_C.z());
    std::vector<Feature> features = {f};
    UndoRollingShutter(camera, kReadout, w, &features);
    EXPECT_LT((Eigen::Vector2d(features[0].u, features[0].v) - truth).norm(), 0.01) << "case " << i;
    EXPECT_NEAR(features[0].u - features[0].u_right, camera.bf() / p_C.z(), 1e-3);
  }
}

}  // namespace
}  // namespace gw::frontend

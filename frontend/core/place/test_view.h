// Images of a made-up scene, for tests that compare images. Not part of the product.
#pragma once

#include "common/core/random.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {

// A cloud of points before the camera, seen from T_OC: a third of them is found in an image, each
// bit of a descriptor is wrong with 5 %.
inline FeatureFrame SeeScene(uint64_t scene, const SE3& T_OC, uint64_t image,
                             int num_points = 4000) {
  const RectifiedCamera camera = TestCamera(6);
  FeatureFrame frame;
  CounterRng points(scene, 1, 0);
  CounterRng chance(scene, 2, image);
  for (int i = 0; i < num_points; ++i) {
    const Eigen::Vector3d p_O(8 * points.Uniform() - 4, 5 * points.Uniform() - 2.5,
                              1.5 + 5 * points.Uniform());
    Descriptor descriptor;
    for (uint64_t& word : descriptor) word = points.NextU64();
    const Eigen::Vector3d p_C = T_OC.inverse() * p_O;
    const bool found = chance.Uniform() < 0.33;
    for (uint64_t& word : descriptor) {
      for (int bit = 0; bit < 64; ++bit) {
        if (chance.Uniform() < 0.05) word ^= uint64_t{1} << bit;
      }
    }
    if (p_C.z() < 0.3 || !found) continue;
    const Eigen::Vector2d uv = camera.Project(p_C);
    if (!camera.InImage(uv)) continue;
    Feature f;
    f.u = static_cast<float>(uv.x() + 0.7 * chance.Normal());
    f.v = static_cast<float>(uv.y() + 0.7 * chance.Normal());
    if (chance.Uniform() < 0.5) f.depth = static_cast<float>(p_C.z());
    frame.features.push_back(f);
    frame.descriptors.push_back(descriptor);
  }
  frame.num_detected = static_cast<int>(frame.features.size());
  return frame;
}

}  // namespace gw::frontend

// Lengths that a camera tells, corrected by a factor.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/contract/map.h"
#include "common/core/se3.h"

namespace gw {

inline Eigen::Vector3d ScaleAround(const Eigen::Vector3d& center, double factor,
                                   const Eigen::Vector3d& p) {
  return center + factor * (p - center);
}

// The pose with its translation scaled.
inline SE3 ScaleLength(double factor, const SE3& T) {
  return SE3(T.rotation(), factor * T.translation());
}

// The features as if the baseline, or unit of depth, had been `factor` (> 0) times as large.
inline void ScaleLengths(double factor, std::vector<Feature>* features) {
  const auto by = static_cast<float>(factor);
  for (Feature& f : *features) {
    if (!f.has_disparity()) continue;
    f.u_right = f.u - (f.u - f.u_right) / by;
    if (f.has_depth()) f.depth *= by;
  }
}

}  // namespace gw

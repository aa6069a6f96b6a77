// One landmark by itself: where its sightings fit best while the cameras stand still.
#pragma once

#include <Eigen/Core>
#include <span>

#include "backend/core/bundle/reprojection.h"

namespace gw::backend {

struct LandmarkSighting {
  SE3 T_CW;
  PixelMeasurement pixel;
};

struct LandmarkFit {
  Eigen::Vector3d p_W;
  // Largest standard deviation of p_W over the least depth at which a camera sees it, from the
  // pixel sigmas of the sightings; infinity when they leave a direction open, or when `start` is
  // not in front of all cameras (p_W is `start` then).
  double vagueness = 0;
};

// Damped Gauss-Newton from `start` on the cost of bundle adjustment: Huber, pixel and depth apart.
// The cost at p_W is never above that at `start`.
LandmarkFit FitLandmark(const RectifiedCamera& camera, std::span<const LandmarkSighting> sightings,
                        const Eigen::Vector3d& start);

}  // namespace gw::backend

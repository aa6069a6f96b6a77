// One landmark by itself: where its observations fit best while the cameras stand still.
#pragma once

#include <Eigen/Core>
#include <span>

#include "common/vision/reprojection.h"

namespace gw::backend {

// An observation, with the pose of its camera.
struct PosedObservation {
  SE3 T_CW;
  PixelObservation pixel;
};

struct LandmarkFit {
  Eigen::Vector3d p_W;
  // Largest standard deviation of p_W over the least depth at which a camera sees it, from the
  // pixel sigmas of the observations; infinity when they leave a direction open, or when `start` is
  // not in front of all cameras (p_W is `start` then).
  double vagueness = 0;
};

// Damped Gauss-Newton from `start` on the cost of bundle adjustment: Huber, pixel and depth apart.
// The cost at p_W is never above that at `start`.
LandmarkFit FitLandmark(const RectifiedCamera& camera,
                        std::span<const PosedObservation> observations,
                        const Eigen::Vector3d& start);

}  // namespace gw::backend

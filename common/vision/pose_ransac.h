// The pose of an image among landmarks without any prediction: RANSAC over 3-D to 3-D triples, for
// features with depth.
#pragma once

#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/core/random.h"
#include "common/core/se3.h"

namespace gw {

// A feature taken for a landmark.
struct PointPair {
  Eigen::Vector3d p_C;      // from pixel and depth
  Eigen::Vector3d p_W;      // the landmark
  Eigen::Vector2d uv;       // px
  double tolerance_px = 4;  // reprojection error up to which the pair agrees with a pose
};

struct PoseHypothesis {
  SE3 T_WC;
  std::vector<uint8_t> inlier;  // one per pair
  int num_inliers = 0;
};

// The pose that most pairs agree with, of 300 triples drawn with `rng` (99 % sure to hit a true
// triple among 25 % true pairs). Empty when fewer than max(min_inliers, 3) agree.
std::optional<PoseHypothesis> FindPose(const RectifiedCamera& camera,
                                       const std::vector<PointPair>& pairs, int min_inliers,
                                       CounterRng rng);

}  // namespace gw

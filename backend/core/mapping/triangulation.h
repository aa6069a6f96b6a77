// New landmarks from two views, for features that have no landmark.
#pragma once

#include <optional>

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

// A feature, with the pose of its camera.
struct PosedFeature {
  SE3 T_WC;
  SE3 T_CW;  // inverse
  Feature feature;
};

// The point that both views see, in W. From the crossing of the rays, or from the depth of a view
// when that says more (its disparity spans a wider angle than the rays). Empty when the angle is
// too small (cos > 0.9998, reference methods 4h) and there is no such depth, when it lies behind a
// camera, misses a chi-square gate, or when its distances do not fit the pyramid levels.
std::optional<Eigen::Vector3d> Triangulate(const MappingContext& context, const PosedFeature& a,
                                           const PosedFeature& b);

// For the newest keyframe: matches its features without landmark along the epipolar segments in its
// best covisible keyframes and creates landmarks (named after the newest keyframe's feature) where
// Triangulate agrees. Returns how many.
int TriangulateNewLandmarks(Map& map, const MappingContext& context);

}  // namespace gw::backend

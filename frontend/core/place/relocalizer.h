// Finds the pose of an image among landmarks without any prediction: descriptors are compared all
// against all, and RANSAC finds the pose that explains most of the pairs (features with depth). For
// the case that neither vision nor DR knows where the camera is.
#pragma once

#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/map/local_map.h"

namespace gw::frontend {

// seed: any number that differs from image to image (draws depend on nothing else).
// Empty when no pose is supported by at least min_inliers pairs.
std::optional<SE3> Relocalize(const RectifiedCamera& camera, double scale_factor,
                              const FeatureFrame& frame, const std::vector<const MapPoint*>& points,
                              int min_inliers, uint64_t seed);

}  // namespace gw::frontend

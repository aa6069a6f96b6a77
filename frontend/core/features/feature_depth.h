// The distance of a feature.
#pragma once

#include "common/camera/camera_model.h"
#include "common/contract/map.h"

namespace gw::frontend {

// A distance so much beyond the range is still told, for landmarks that stand within it: farther
// off than noise brings one of them, it is a wrong match.
inline constexpr float kBeyondRange = 1.5F;

// depth: m; disparity: px, bf / depth. The feature keeps none where that is far beyond the camera's
// range.
inline void SetDepth(const RectifiedCamera& camera, float depth, float disparity, Feature* f) {
  f->depth = f->u_right = -1;
  if (depth > kBeyondRange * camera.depth_max_m) return;
  if (depth <= camera.depth_max_m) f->depth = depth;
  f->u_right = f->u - disparity;
}

}  // namespace gw::frontend

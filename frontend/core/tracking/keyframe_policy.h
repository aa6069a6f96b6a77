// When an image becomes a keyframe. Pure arithmetic on what the tracker knows of the image.
#pragma once

#include "common/config/frontend_config.h"
#include "common/core/time.h"

namespace gw::frontend {

struct KeyframeEvidence {
  DurationUs since_last{0};
  bool vision = true;  // the pose comes from vision (not DR alone)
  int num_inliers = 0;
  int num_mapped = 0;  // landmarks of the map's most similar view: what there is to be tracked
  int num_close_tracked = 0;    // inliers with depth
  int num_close_untracked = 0;  // features with depth that show no landmark yet
  double translation_m = 0;     // since the last keyframe
  double rotation_rad = 0;
  double median_depth_m = 0;  // of the features with depth; 0: unknown
  int unmatched_images = 0;   // in a row with features, but without a pose from vision
};

bool NeedsKeyframe(const KeyframeEvidence& evidence, const FrontendConfig& config);

}  // namespace gw::frontend

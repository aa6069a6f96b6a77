// Why the pose of an image is what it is: for viewers and reports.
#pragma once

#include <cstdint>
#include <vector>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw {

// What became of one feature of an image.
enum class FeatureFate : uint8_t {
  kUnmatched = 0,  // shows no landmark of the local map
  kInlier = 1,     // shows a landmark, and agrees with the pose
  kOutlier = 2,    // was matched to a landmark, and contradicts the pose
  kNew = 3,        // became a landmark with the keyframe made of this image
};

// What alone decided how much dead reckoning counts in the pose of an image.
enum class AlphaBound : int32_t {
  kUnused = 0,      // no prior from dead reckoning
  kNone = 1,        // the quality of vision: alpha between its bounds
  kAlphaMin = 2,    // vision is healthy
  kAlphaMax = 3,    // vision is blind, or nearly
  kCovariance = 4,  // what dead reckoning claims of itself (docs/adr/0012-no-more-than-dr-knows.md)
  kDistrusted = 5,  // dead reckoning contradicts healthy vision
};

// Why the pose of an image is what it is, for people: no estimator uses it.
struct FrameDetail {
  Utime utime;         // of the image
  int64_t seq = 0;     // of the camera message
  double q = 0;        // tracking quality of all features, [0, 1]
  double q_close = 0;  // of the features with depth
  // Scales of the information of the prior by the law of alpha, and after the bound: what was
  // really used (docs/method.md, sections 3.2 and 3.3). All four are 0 where no prior was used.
  double alpha_translation = 0, alpha_rotation = 0;
  double bounded_translation = 0, bounded_rotation = 0;
  AlphaBound bound = AlphaBound::kUnused;
  // Share of the DR prior in the pose along and about the axes x, y, z of B, [0, 1]: the diagonal
  // of (H_v + H_p)^-1 H_p, the weight of the prior in the mean; H: informations of vision and
  // prior.
  Vector6d dr_share = Vector6d::Zero();
  struct Feature {
    float u = 0, v = 0;  // px, in the rectified image
    FeatureFate fate = FeatureFate::kUnmatched;
  };
  std::vector<Feature> features;
};

}  // namespace gw

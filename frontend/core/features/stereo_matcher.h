// Disparity of the left image's features: candidates on the same row of the right image by
// descriptor, then a sub-pixel comparison of patches.
#pragma once

#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "frontend/core/features/image_pyramid.h"
#include "frontend/core/features/orb_keypoint.h"

namespace gw::frontend {

// One rectified image with its features.
struct StereoSide {
  const ImagePyramid& pyramid;
  const std::vector<OrbKeypoint>& keypoints;
  const std::vector<Descriptor>& descriptors;
};

class StereoMatcher {
 public:
  explicit StereoMatcher(const RectifiedCamera& camera);

  // One entry per left keypoint: disparity u_left - u_right (px of level 0), or -1 for none.
  // Disparities of points nearer than depth_min_m are not searched; far ones are reported down to
  // zero, so that a far point does not take the place of a wrong near one.
  void Match(const StereoSide& left, const StereoSide& right, std::vector<float>* disparities);

 private:
  float max_disparity_;
  int height_;
  std::vector<int> row_begin_;  // of by_row_, per row of the right image; one more at the end
  std::vector<int> by_row_;     // right keypoints, sorted by row
  std::vector<float> cost_;     // per left keypoint: patch difference, or -1
  std::vector<float> sorted_cost_;
};

}  // namespace gw::frontend

// Disparity of the left image's features: candidates on the same row of the right image by
// descriptor, then a sub-pixel comparison of patches.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "frontend/core/features/feature_frame.h"
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

  // Measures on a sample of the fine features how far their unmistakable partners lie off their
  // rows, within 8 px of the level, whatever disparity Match gave them. Call after Match.
  void MeasureRowOffsets(const StereoSide& left, const StereoSide& right,
                         std::vector<FeatureFrame::RowOffset>* out) const;

 private:
  void SortByRow(const std::vector<OrbKeypoint>& right);
  // The right keypoint that looks most like the i-th left one, on its rows; -1: none.
  int MostSimilar(const StereoSide& left, size_t i, const StereoSide& right) const;
  // The disparity of a left keypoint, px of level 0, not below zero, from the images around it and
  // its partner.
  std::optional<float> Measure(const StereoSide& left, const OrbKeypoint& k,
                               const StereoSide& right, const OrbKeypoint& partner) const;

  float max_disparity_;
  int height_;
  std::vector<int> row_begin_;  // of by_row_, per row of the right image; one more at the end
  // A right keypoint, as far as it tells whether its descriptor is worth a look.
  struct InRow {
    float u, v;
    int level;
    int index;
  };
  std::vector<InRow> by_row_;  // sorted by row
  // Those of the rows first to last. Preconditions: 0 <= first, last < height_.
  std::span<const InRow> InRows(int first, int last) const {
    const int begin = row_begin_[static_cast<size_t>(first)];
    return {by_row_.data() + begin, by_row_.data() + row_begin_[static_cast<size_t>(last) + 1]};
  }
};

}  // namespace gw::frontend

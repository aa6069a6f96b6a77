// Disparity of the left image's features: candidates on the same row of the right image by
// descriptor, then a sub-pixel comparison of patches.
#pragma once

#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/orb_keypoint.h"
#include "frontend/core/features/row_index.h"

namespace gw::frontend {

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
  // The right keypoint that looks most like the i-th left one, on its rows; -1: none.
  int MostSimilar(const StereoSide& left, size_t i, const StereoSide& right) const;
  // The disparity of a left keypoint, px of level 0, not below zero, from the images around it and
  // its partner.
  std::optional<float> Measure(const StereoSide& left, const OrbKeypoint& k,
                               const StereoSide& right, const OrbKeypoint& partner) const;

  float max_disparity_;
  RowIndex right_rows_;
};

}  // namespace gw::frontend

// Corners followed through a moving stereo camera: what the calibration of its eyes is judged by.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "common/core/image_view.h"

namespace gw::tools {

// One corner in two stereo pairs, px of the images as the camera gave them.
struct StereoTrack {
  Eigen::Vector2d left0, right0, left1, right1;
};
using PairTracks = std::vector<StereoTrack>;

// Pyramidal Lucas-Kanade (Bouguet 2001), left to right and old to new, kept when tracking back ends
// where it began and both ways from the old left to the new right image agree.
class StereoTracker {
 public:
  // Tracks between the pair that is held and this one, once the image has moved enough; then this
  // pair is held instead. Empty: not yet, or the scene was lost and a new start is made here.
  // Precondition: kGray8, both of one size, the same in all calls.
  std::optional<PairTracks> Push(const ImageView& left, const ImageView& right);

 private:
  PairTracks Track(const cv::Mat& left, const cv::Mat& right) const;
  void Hold(const cv::Mat& left, const cv::Mat& right);

  cv::Mat left_, right_;  // the pair that is held; empty at first
  std::vector<cv::Point2f> left_corners_, right_corners_;
};

}  // namespace gw::tools

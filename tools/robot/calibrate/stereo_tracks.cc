#include "tools/robot/calibrate/stereo_tracks.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "common/core/median.h"

namespace gw::tools {
namespace {

constexpr double kMinMotionPx = 6;      // median way of the corners between two pairs
constexpr size_t kMinTracks = 60;       // fewer: the scene is lost
constexpr float kMaxReturnPx = 0.3F;    // tracking there and back
constexpr float kMaxDetourPx = 0.7F;    // old left to new right by either way
constexpr float kMaxVerticalPx = 4.0F;  // between the eyes of a pair that is roughly rectified

cv::Mat ToMat(const ImageView& image) {
  // OpenCV has no const view; the copy also lets a pair outlive its message.
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                 static_cast<size_t>(image.stride))
      .clone();
}

float Distance(const cv::Point2f& a, const cv::Point2f& b) {
  return static_cast<float>(cv::norm(a - b));
}

// Corners spread over the image: the strongest few of each tile.
std::vector<cv::Point2f> FindCorners(const cv::Mat& image) {
  constexpr int kTilePx = 56;
  constexpr int kCornersPerTile = 6;
  std::vector<cv::Point2f> corners;
  for (int y = 0; y < image.rows; y += kTilePx) {
    for (int x = 0; x < image.cols; x += kTilePx) {
      const cv::Rect tile =
          cv::Rect(x, y, kTilePx, kTilePx) & cv::Rect(0, 0, image.cols, image.rows);
      std::vector<cv::Point2f> found;
      cv::goodFeaturesToTrack(image(tile), found, kCornersPerTile, 0.02, 5);
      for (const cv::Point2f& p : found) {
        corners.push_back(p + cv::Point2f(static_cast<float>(x), static_cast<float>(y)));
      }
    }
  }
  return corners;
}

struct Followed {
  std::vector<cv::Point2f> points;
  std::vector<bool> good;
};

Followed Follow(const cv::Mat& from, const cv::Mat& to, const std::vector<cv::Point2f>& corners) {
  Followed result;
  result.good.assign(corners.size(), false);
  result.points = corners;
  if (corners.empty()) return result;
  const cv::Size window(21, 21);
  constexpr int kLevels = 4;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 0.005);
  std::vector<uint8_t> there, back;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(from, to, corners, result.points, there, error, window, kLevels, stop);
  std::vector<cv::Point2f> returned = corners;
  cv::calcOpticalFlowPyrLK(to, from, result.points, returned, back, error, window, kLevels, stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  for (size_t i = 0; i < corners.size(); ++i) {
    result.good[i] =
        there[i] != 0 && back[i] != 0 && Distance(corners[i], returned[i]) < kMaxReturnPx;
  }
  return result;
}

Eigen::Vector2d ToEigen(const cv::Point2f& p) {
  return {p.x, p.y};
}

double MedianMotion(const PairTracks& tracks) {
  std::vector<double> ways;
  ways.reserve(tracks.size());
  for (const StereoTrack& t : tracks) ways.push_back((t.left1 - t.left0).norm());
  return MedianOf(&ways);
}

}  // namespace

void StereoTracker::Hold(const cv::Mat& left, const cv::Mat& right) {
  left_ = left;
  right_ = right;
  left_corners_.clear();
  right_corners_.clear();
  const std::vector<cv::Point2f> corners = FindCorners(left);
  const Followed across = Follow(left, right, corners);
  for (size_t i = 0; i < corners.size(); ++i) {
    if (across.good[i] && std::abs(corners[i].y - across.points[i].y) < kMaxVerticalPx) {
      left_corners_.push_back(corners[i]);
      right_corners_.push_back(across.points[i]);
    }
  }
}

PairTracks StereoTracker::Track(const cv::Mat& left, const cv::Mat& right) const {
  const Followed new_left = Follow(left_, left, left_corners_);
  const Followed new_right = Follow(right_, right, right_corners_);
  const Followed across = Follow(left, right, new_left.points);
  PairTracks tracks;
  for (size_t i = 0; i < left_corners_.size(); ++i) {
    if (!new_left.good[i] || !new_right.good[i] || !across.good[i] ||
        Distance(new_right.points[i], across.points[i]) > kMaxDetourPx) {
      continue;
    }
    tracks.push_back({ToEigen(left_corners_[i]), ToEigen(right_corners_[i]),
                      ToEigen(new_left.points[i]), ToEigen(across.points[i])});
  }
  return tracks;
}

std::optional<PairTracks> StereoTracker::Push(const ImageView& left, const ImageView& right) {
  const cv::Mat new_left = ToMat(left);
  const cv::Mat new_right = ToMat(right);
  if (left_.empty()) {
    Hold(new_left, new_right);
    return std::nullopt;
  }
  PairTracks tracks = Track(new_left, new_right);
  const bool lost = tracks.size() < kMinTracks;
  if (!lost && MedianMotion(tracks) < kMinMotionPx) return std::nullopt;
  Hold(new_left, new_right);
  if (lost) return std::nullopt;
  return tracks;
}

}  // namespace gw::tools

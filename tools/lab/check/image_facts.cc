#include "tools/lab/check/image_facts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>

namespace gw::check {
namespace {

constexpr DurationUs kSample = Milliseconds(250);  // between images that are looked at closely
constexpr int kCorners = 150;

cv::Mat MatOf(const ImageView& view) {
  const int type = view.format == PixelFormat::kGray8 ? CV_8UC1 : CV_16UC1;
  // cv::Mat has no view of constant pixels; they are not written.
  return {view.height, view.width, type, const_cast<uint8_t*>(view.data),
          static_cast<size_t>(view.stride)};
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), a.cols * a.elemSize()) != 0) return false;
  }
  return true;
}

double Quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<int64_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Gradient energy of two bands two octaves apart.
double SharpnessOf(const cv::Mat& image) {
  cv::Mat grey, fine, coarse, coarser;
  image.convertTo(grey, CV_32F);
  cv::GaussianBlur(grey, fine, {}, 1.0);
  cv::GaussianBlur(grey, coarse, {}, 4.0);
  cv::GaussianBlur(grey, coarser, {}, 8.0);
  cv::Mat one, two;
  cv::GaussianBlur(fine, one, {}, 1.732);  // sigma 2 in all
  const double fine_band = cv::norm(fine - one, cv::NORM_L2SQR);
  const double coarse_band = cv::norm(coarse - coarser, cv::NORM_L2SQR);
  return coarse_band > 0 ? std::sqrt(fine_band / coarse_band) : 0;
}

// Pixel of an eye as the rectified camera sees it; nothing where that fails.
std::optional<Eigen::Vector2d> Rectified(const RectifiedCamera& camera,
                                         const PinholeIntrinsics& eye,
                                         const Eigen::Matrix3d& R_EyeRect, const cv::Point2f& p) {
  const auto ideal = Undistort(eye, {(p.x - eye.cx) / eye.fx, (p.y - eye.cy) / eye.fy});
  if (!ideal) return std::nullopt;
  const Eigen::Vector3d ray = R_EyeRect.transpose() * Eigen::Vector3d(ideal->x(), ideal->y(), 1);
  if (ray.z() <= 1e-6) return std::nullopt;
  return camera.Project(ray);
}

// Corners of `left` and where they are in `right`, found both ways alike.
void MatchCorners(const cv::Mat& left, const cv::Mat& right, std::vector<cv::Point2f>& a,
                  std::vector<cv::Point2f>& b) {
  cv::goodFeaturesToTrack(left, a, kCorners, 0.02, 8);
  if (a.empty()) return;
  std::vector<cv::Point2f> back;
  std::vector<uint8_t> found, found_back;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(left, right, a, b, found, error, {21, 21}, 4);
  cv::calcOpticalFlowPyrLK(right, left, b, back, found_back, error, {21, 21}, 4);
  size_t kept = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (found[i] == 0 || found_back[i] == 0 || cv::norm(back[i] - a[i]) > 0.5) continue;
    a[kept] = a[i];
    b[kept++] = b[i];
  }
  a.resize(kept);
  b.resize(kept);
}

}  // namespace

struct ImageScanner::State {
  CameraGeometry geometry;
  ImageFacts facts;
  cv::Mat last;
  std::optional<Utime> last_sample;
  std::vector<double> sharpness;

  PairFact PairOf(const CameraFrame& frame) const {
    PairFact fact;
    fact.utime = frame.utime;
    std::vector<cv::Point2f> a, b;
    MatchCorners(MatOf(frame.left), MatOf(frame.right), a, b);
    const CameraCalibration& camera = geometry.calibration.camera;
    const StereoRectification& rectification = geometry.rectification;
    std::vector<double> disparities, rows;
    for (size_t i = 0; i < a.size(); ++i) {
      const auto l = Rectified(geometry.rectified, camera.left, rectification.R_C0Rect, a[i]);
      const auto r = Rectified(geometry.rectified, camera.right, rectification.R_C1Rect, b[i]);
      if (!l || !r) continue;
      disparities.push_back(l->x() - r->x());
      rows.push_back(l->y() - r->y());
    }
    fact.matches = static_cast<int>(rows.size());
    fact.disparity_low_px = Quantile(disparities, 0.1);
    fact.disparity_median_px = Quantile(disparities, 0.5);
    fact.row_offset_px = Quantile(rows, 0.5);
    for (double& row : rows) row = std::abs(row - fact.row_offset_px);
    fact.row_spread_px = Quantile(rows, 0.5);
    return fact;
  }

  DepthFact DepthOf(const ImageView& depth) const {
    const CameraCalibration& camera = geometry.calibration.camera;
    const cv::Mat pixels = MatOf(depth);
    std::vector<double> metres;
    int usable = 0, total = 0;
    for (int y = 2; y < pixels.rows; y += 4) {
      for (int x = 2; x < pixels.cols; x += 4, ++total) {
        const uint16_t value = pixels.at<uint16_t>(y, x);
        if (value == 0) continue;
        const double m = value * camera.depth_unit_m;
        metres.push_back(m);
        if (m >= camera.depth_min_m && m <= camera.depth_max_m) ++usable;
      }
    }
    DepthFact fact;
    if (metres.empty() || total == 0) return fact;
    fact.measured_share = static_cast<double>(metres.size()) / total;
    fact.usable_share = usable / static_cast<double>(metres.size());
    fact.median_m = Quantile(metres, 0.5);
    return fact;
  }
};

ImageScanner::ImageScanner(const CameraGeometry& geometry) : state_(std::make_unique<State>()) {
  state_->geometry = geometry;
}
ImageScanner::~ImageScanner() = default;

void ImageScanner::Push(const CameraFrame& frame) {
  const cv::Mat left = MatOf(frame.left);
  ImageFact fact;
  fact.utime = frame.utime;
  fact.width = left.cols;
  fact.height = left.rows;
  fact.mean_grey = cv::mean(left)[0];
  fact.burnt_share = cv::countNonZero(left >= 250) / static_cast<double>(left.total());
  fact.same_as_last = SameBytes(left, state_->last);
  fact.same_eyes = !frame.right.empty() && SameBytes(left, MatOf(frame.right));
  state_->facts.images.push_back(fact);
  state_->last = left.clone();
  const std::optional<Utime> last = state_->last_sample;
  if (last && frame.utime - *last < kSample && *last < frame.utime) return;
  state_->last_sample = frame.utime;
  state_->sharpness.push_back(SharpnessOf(left));
  state_->facts.patterns.Push(frame.utime, frame.left);
  if (!frame.right.empty() && frame.right.width == frame.left.width &&
      frame.right.height == frame.left.height) {
    state_->facts.pairs.push_back(state_->PairOf(frame));
  }
  if (!frame.depth.empty()) state_->facts.depths.push_back(state_->DepthOf(frame.depth));
}

ImageFacts ImageScanner::Finish() {
  if (!state_->sharpness.empty()) state_->facts.sharpness = Quantile(state_->sharpness, 0.5);
  return std::move(state_->facts);
}

}  // namespace gw::check

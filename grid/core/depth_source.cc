#include "grid/core/depth_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace gw::grid {
namespace {

// A floor map needs no more pixels than these: 320 over 80 degrees are a cell of 5 cm apart at 10
// m.
constexpr int kEnoughColumns = 320;
constexpr int kEnoughRows = 240;
// For a stereo pair the error of a disparity is a part of a pixel, so columns are worth more here.
// Rows may be joined, they tell the same disparity.
constexpr int kEnoughStereoColumns = 640;

// A pixel of a depth image is off by the noise of its disparity, which the calibration tells, and
// by what that does not hold: the steps in which it is told, and the mounting of the camera.
// From 1.25 to 1.9 times as much serves as well (docs/adr/0037-free-is-seen-floor.md).
constexpr double kPixelNoise = 1.5;

int Reduction(int pixels, int enough) {
  return std::max(1, pixels / enough);
}

Eigen::Vector3f ToFloat(const Eigen::Vector3d& v) {
  return v.cast<float>();
}

}  // namespace

void RemoveEdges(int width, double focal_px, DepthImage* depth) {
  constexpr int kReach = 2;  // columns to each side
  const double steepest = kReach / (focal_px * kNearestPlane);
  std::vector<float> inverse(static_cast<size_t>(width));
  for (size_t row = 0; row + static_cast<size_t>(width) <= depth->size();
       row += static_cast<size_t>(width)) {
    float* z = depth->data() + row;
    for (int u = 0; u < width; ++u) inverse[static_cast<size_t>(u)] = z[u] > 0 ? 1 / z[u] : 0;
    for (int u = 0; u < width; ++u) {
      for (const int other : {std::max(0, u - kReach), std::min(width - 1, u + kReach)}) {
        const float here = inverse[static_cast<size_t>(u)];
        const float there = inverse[static_cast<size_t>(other)];
        if (here > 0 && there > 0 && std::abs(here - there) > steepest) z[u] = 0;
      }
    }
  }
}

namespace {

class RgbdDepth : public DepthSource {
 public:
  explicit RgbdDepth(const CameraGeometry& geometry)
      : camera_(geometry.calibration.camera),
        step_u_(Reduction(camera_.width, kEnoughColumns)),
        step_v_(Reduction(camera_.height, kEnoughRows)) {
    rays_.width = camera_.width / step_u_;
    rays_.height = camera_.height / step_v_;
    rays_.origin = ToFloat(camera_.T_BC.translation());
    rays_.sigma_per_m2 =
        kPixelNoise * camera_.disparity_sigma_px / (camera_.left.fx * camera_.depth_baseline_m);
    for (int v = 0; v < rays_.height; ++v) {
      for (int u = 0; u < rays_.width; ++u) {
        const Eigen::Vector2d pixel((u * step_u_ - camera_.left.cx) / camera_.left.fx,
                                    (v * step_v_ - camera_.left.cy) / camera_.left.fy);
        const auto ideal = Undistort(camera_.left, pixel);
        // A pixel whose direction is not known has no ray, and never a point.
        rays_.ray.push_back(
            ideal ? ToFloat(camera_.T_BC.rotation() * Eigen::Vector3d(ideal->x(), ideal->y(), 1))
                  : Eigen::Vector3f(0, 0, 0));
      }
    }
  }

  bool Measure(const CameraFrame& frame, DepthImage* depth) override {
    const ImageView& image = frame.depth;
    if (!image.Is(PixelFormat::kDepth16, camera_.width, camera_.height)) return false;
    depth->assign(rays_.ray.size(), 0.0f);
    float* out = depth->data();
    for (int v = 0; v < rays_.height; ++v) {
      const uint8_t* row = image.data + static_cast<ptrdiff_t>(v) * step_v_ * image.stride;
      for (int u = 0; u < rays_.width; ++u, ++out) {
        uint16_t raw = 0;
        std::memcpy(&raw, row + static_cast<ptrdiff_t>(u) * step_u_ * 2, 2);
        const double z = raw * camera_.depth_unit_m;
        if (z >= camera_.depth_min_m) *out = static_cast<float>(z);
      }
    }
    RemoveEdges(rays_.width, camera_.left.fx / step_u_, depth);
    return true;
  }

 private:
  CameraCalibration camera_;
  int step_u_, step_v_;
};

cv::Mat View(const ImageView& image) {
  // OpenCV has no look at constant pixels; nothing writes through this one.
  return {image.height, image.width, CV_8U, const_cast<uint8_t*>(image.data),
          static_cast<size_t>(image.stride)};
}

class StereoDepth : public DepthSource {
 public:
  StereoDepth(const CameraGeometry& geometry, const GridConfig& config)
      : camera_(geometry.rectified),
        step_u_(Reduction(camera_.width, kEnoughStereoColumns)),
        step_v_(Reduction(camera_.height, kEnoughRows)),
        rectify_(geometry.rectification.needed) {
    rays_.width = camera_.width / step_u_;
    rays_.height = camera_.height / step_v_;
    rays_.origin = ToFloat(camera_.T_BC.translation());
    rays_.sigma_per_m2 = config.disparity_sigma_px / camera_.bf();
    // The centre of a reduced pixel in the image of full size.
    const double offset_u = (step_u_ - 1) / 2.0, offset_v = (step_v_ - 1) / 2.0;
    for (int v = 0; v < rays_.height; ++v) {
      for (int u = 0; u < rays_.width; ++u) {
        rays_.ray.push_back(
            ToFloat(camera_.T_BC.rotation() *
                    camera_.Unproject(u * step_u_ + offset_u, v * step_v_ + offset_v, 1)));
      }
    }
    if (rectify_) MakeMaps(geometry);
    const double largest = camera_.bf() / step_u_ / camera_.depth_min_m;
    const int disparities = 16 * static_cast<int>(std::ceil(largest / 16));
    // Penalties as OpenCV's documentation of StereoSGBM suggests: 8 and 32 times the window.
    matcher_ = cv::StereoSGBM::create(0, disparities, kWindow, 8 * kWindow * kWindow,
                                      32 * kWindow * kWindow, kLeftRight, 0, kUniqueness, kIsland,
                                      kIslandStep, cv::StereoSGBM::MODE_SGBM_3WAY);
  }

  bool Measure(const CameraFrame& frame, DepthImage* depth) override {
    for (const ImageView* image : {&frame.left, &frame.right}) {
      if (!image->Is(PixelFormat::kGray8, camera_.width, camera_.height)) return false;
    }
    const cv::Mat left = Reduced(frame.left, 0);
    const cv::Mat right = Reduced(frame.right, 1);
    cv::Mat disparity;
    matcher_->compute(left, right, disparity);
    const cv::Mat structure = Structure(left);
    const auto scale = static_cast<float>(camera_.bf() / step_u_ * kDisparityUnit);
    depth->assign(rays_.ray.size(), 0.0f);
    float* out = depth->data();
    for (int v = 0; v < rays_.height; ++v) {
      const auto* found = disparity.ptr<int16_t>(v);
      const auto* gradient = structure.ptr<float>(v);
      for (int u = 0; u < rays_.width; ++u, ++out) {
        if (found[u] > 0 && gradient[u] >= kLeastGradient) {
          *out = scale / static_cast<float>(found[u]);
        }
      }
    }
    RemoveEdges(rays_.width, camera_.fx / step_u_, depth);
    return true;
  }

 private:
  static constexpr int kWindow = 5;       // px
  static constexpr int kLeftRight = 1;    // px that the two eyes may differ
  static constexpr int kUniqueness = 10;  // per cent that the best match must be better
  static constexpr int kIsland = 60;      // px: smaller connected pieces are no surface
  static constexpr int kIslandStep = 2;   // px of disparity between neighbours of one piece
  static constexpr int kDisparityUnit = 16;
  // Mean absolute difference of neighbours that the noise of an image makes: grey levels.
  static constexpr float kLeastGradient = 1.0f;

  void MakeMaps(const CameraGeometry& geometry) {
    const CameraCalibration& camera = geometry.calibration.camera;
    for (int eye = 0; eye < 2; ++eye) {
      cv::Mat map(camera_.height, camera_.width, CV_32FC2);
      for (int v = 0; v < camera_.height; ++v) {
        for (int u = 0; u < camera_.width; ++u) {
          const Eigen::Vector2d at =
              eye == 0
                  ? RectifiedToSource(camera_, camera.left, geometry.rectification.R_C0Rect, {u, v})
                  : RectifiedToSource(camera_, camera.right, geometry.rectification.R_C1Rect,
                                      {u, v});
          map.at<cv::Vec2f>(v, u) = {static_cast<float>(at.x()), static_cast<float>(at.y())};
        }
      }
      cv::convertMaps(map, cv::noArray(), maps_[eye], weights_[eye], CV_16SC2);
    }
  }

  cv::Mat Reduced(const ImageView& image, int eye) const {
    cv::Mat full = View(image);
    if (rectify_) {
      cv::Mat rectified;
      cv::remap(full, rectified, maps_[eye], weights_[eye], cv::INTER_LINEAR);
      full = rectified;
    }
    cv::Mat reduced;
    cv::resize(full, reduced, {rays_.width, rays_.height}, 0, 0, cv::INTER_AREA);
    return reduced;
  }

  // Mean absolute horizontal gradient in the window around each pixel.
  static cv::Mat Structure(const cv::Mat& image) {
    cv::Mat gradient, structure;
    cv::Sobel(image, gradient, CV_32F, 1, 0, 1, 0.5);
    cv::boxFilter(cv::abs(gradient), structure, CV_32F, {kWindow, kWindow});
    return structure;
  }

  RectifiedCamera camera_;
  int step_u_, step_v_;
  bool rectify_;
  cv::Mat maps_[2], weights_[2];
  cv::Ptr<cv::StereoSGBM> matcher_;
};

}  // namespace

std::unique_ptr<DepthSource> MakeDepthSource(const CameraGeometry& geometry,
                                             const GridConfig& config) {
  if (geometry.calibration.camera.kind == CameraKind::kRgbd) {
    return std::make_unique<RgbdDepth>(geometry);
  }
  return std::make_unique<StereoDepth>(geometry, config);
}

}  // namespace gw::grid

#include "frontend/core/features/image_undistorter.h"

#include <limits>

namespace gw::frontend {

ImageUndistorter::ImageUndistorter(const CameraGeometry& geometry)
    : identity_(!geometry.calibration.camera.left.distorted()),
      width_(geometry.rectified.width),
      height_(geometry.rectified.height) {
  if (identity_) return;
  const PinholeIntrinsics& source = geometry.calibration.camera.left;
  const RectifiedCamera& rectified = geometry.rectified;
  columns_ = (width_ - 1) / kSpacing + 2;
  const int rows = (height_ - 1) / kSpacing + 2;
  shift_.reserve(static_cast<size_t>(columns_) * static_cast<size_t>(rows));
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns_; ++i) {
      const Eigen::Vector2d pixel(i * kSpacing, j * kSpacing);
      const Eigen::Vector2d distorted((pixel.x() - source.cx) / source.fx,
                                      (pixel.y() - source.cy) / source.fy);
      const Result<Eigen::Vector2d> n = gw::Undistort(source, distorted);
      // Where the distortion folds over, Newton's method may end on the opposite side.
      if (!n || n->dot(distorted) < 0) {
        shift_.emplace_back(kNan, kNan);
        continue;
      }
      const Eigen::Vector2d ideal(rectified.fx * n->x() + rectified.cx,
                                  rectified.fy * n->y() + rectified.cy);
      shift_.push_back((ideal - pixel).cast<float>());
    }
  }
}

std::optional<Eigen::Vector2f> ImageUndistorter::Undistort(float u, float v) const {
  if (!(u >= 0 && v >= 0 && u <= static_cast<float>(width_ - 1) &&
        v <= static_cast<float>(height_ - 1))) {
    return std::nullopt;
  }
  if (identity_) return Eigen::Vector2f(u, v);
  const int i = static_cast<int>(u) / kSpacing;
  const int j = static_cast<int>(v) / kSpacing;
  const float a = u / kSpacing - static_cast<float>(i);
  const float b = v / kSpacing - static_cast<float>(j);
  const Eigen::Vector2f* upper = shift_.data() + static_cast<ptrdiff_t>(j) * columns_ + i;
  const Eigen::Vector2f* lower = upper + columns_;
  const Eigen::Vector2f shift =
      (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
  if (!shift.allFinite()) return std::nullopt;
  return Eigen::Vector2f(u, v) + shift;
}

}  // namespace gw::frontend

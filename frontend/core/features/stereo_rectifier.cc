#include "frontend/core/features/stereo_rectifier.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace gw::frontend {
namespace {

constexpr int kSteps = 32;  // of the position inside a source pixel: at most 1/64 px off

// Two passes of the city-block idea with the larger of |dx|, |dy| as distance.
void DistanceToInvalid(ImageBuffer* map) {
  const auto relax = [map](int x, int y, int dx, int dy) {
    const int nx = x + dx;
    const int ny = y + dy;
    if (nx < 0 || ny < 0 || nx >= map->width || ny >= map->height) return;
    const int through = std::min(255, map->row(ny)[nx] + 1);
    map->row(y)[x] = static_cast<uint8_t>(std::min<int>(map->row(y)[x], through));
  };
  for (int y = 0; y < map->height; ++y) {
    for (int x = 0; x < map->width; ++x) {
      relax(x, y, -1, -1);
      relax(x, y, 0, -1);
      relax(x, y, 1, -1);
      relax(x, y, -1, 0);
    }
  }
  for (int y = map->height - 1; y >= 0; --y) {
    for (int x = map->width - 1; x >= 0; --x) {
      relax(x, y, 1, 1);
      relax(x, y, 0, 1);
      relax(x, y, -1, 1);
      relax(x, y, 1, 0);
    }
  }
}

}  // namespace

StereoRectifier::StereoRectifier(const CameraGeometry& geometry, Eye eye)
    : width_(geometry.rectified.width), height_(geometry.rectified.height) {
  const bool left = eye == Eye::kLeft;
  const CameraCalibration& camera = geometry.calibration.camera;
  const PinholeIntrinsics& source = left ? camera.left : camera.right;
  const Eigen::Matrix3d& R_SourceRect =
      left ? geometry.rectification.R_C0Rect : geometry.rectification.R_C1Rect;
  const size_t num_pixels = static_cast<size_t>(width_) * static_cast<size_t>(height_);
  source_x_.assign(num_pixels, -1);
  source_y_.assign(num_pixels, -1);
  fraction_.assign(num_pixels, 0);
  valid_.Resize(width_, height_, width_);
  std::fill(valid_.pixels.begin(), valid_.pixels.end(), uint8_t{255});
  size_t i = 0;
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u, ++i) {
      const Eigen::Vector2d uv =
          RectifiedToSource(geometry.rectified, source, R_SourceRect, Eigen::Vector2d(u, v));
      // The four neighbours must exist.
      if (!(uv.x() >= 0 && uv.y() >= 0 && uv.x() < camera.width - 1 - 0.5 / kSteps &&
            uv.y() < camera.height - 1 - 0.5 / kSteps)) {
        valid_.row(v)[u] = 0;
        continue;
      }
      const int x = static_cast<int>(std::lround(uv.x() * kSteps));
      const int y = static_cast<int>(std::lround(uv.y() * kSteps));
      source_x_[i] = x / kSteps;
      source_y_[i] = y / kSteps;
      fraction_[i] = static_cast<uint16_t>((y % kSteps) << 8 | (x % kSteps));
    }
  }
  DistanceToInvalid(&valid_);
}

void StereoRectifier::Rectify(const ImageView& source, ImageBuffer* rectified) const {
  GW_CHECK(source.format == PixelFormat::kGray8 && source.width == width_ &&
           source.height == height_);
  rectified->Resize(width_, height_, width_);
  size_t i = 0;
  for (int v = 0; v < height_; ++v) {
    uint8_t* out = rectified->row(v);
    for (int u = 0; u < width_; ++u, ++i) {
      if (source_x_[i] < 0) {
        out[u] = 0;
        continue;
      }
      const uint8_t* upper =
          source.data + static_cast<ptrdiff_t>(source_y_[i]) * source.stride + source_x_[i];
      const uint8_t* lower = upper + source.stride;
      const int a = fraction_[i] & 0xFF;
      const int b = fraction_[i] >> 8;
      const int top = upper[0] * (kSteps - a) + upper[1] * a;
      const int bottom = lower[0] * (kSteps - a) + lower[1] * a;
      out[u] = static_cast<uint8_t>((top * (kSteps - b) + bottom * b + kSteps * kSteps / 2) /
                                    (kSteps * kSteps));
    }
  }
}

}  // namespace gw::frontend

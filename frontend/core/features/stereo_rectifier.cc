#include "frontend/core/features/stereo_rectifier.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace gw::frontend {
namespace {

constexpr uint32_t kSteps = 32;  // of the position inside a source pixel: at most 1/64 px off

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
  sources_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), Source{});
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
      sources_[i] = {static_cast<uint16_t>(x / kSteps), static_cast<uint16_t>(y / kSteps),
                     static_cast<uint8_t>(x % kSteps), static_cast<uint8_t>(y % kSteps)};
    }
  }
  DistanceToInvalid(&valid_);
}

void StereoRectifier::Rectify(const ImageView& source, ImageBuffer* rectified) const {
  GW_CHECK(source.Is(PixelFormat::kGray8, width_, height_));
  rectified->Resize(width_, height_, width_);
  const Source* s = sources_.data();
  for (int v = 0; v < height_; ++v) {
    uint8_t* out = rectified->row(v);
    const uint8_t* valid = valid_.row(v);
    for (int u = 0; u < width_; ++u, ++s) {
      const uint8_t* upper = source.data + static_cast<ptrdiff_t>(s->y) * source.stride + s->x;
      const uint8_t* lower = upper + source.stride;
      // Both columns at once, the right one in the upper half of 32 bits: at most 255 * kSteps.
      const uint32_t above = upper[0] | static_cast<uint32_t>(upper[1]) << 16;
      const uint32_t below = lower[0] | static_cast<uint32_t>(lower[1]) << 16;
      const uint32_t columns = above * (kSteps - s->below) + below * s->below;
      const uint32_t sum = (columns & 0xFFFF) * (kSteps - s->right) + (columns >> 16) * s->right;
      const uint8_t pixel = static_cast<uint8_t>((sum + kSteps * kSteps / 2) / (kSteps * kSteps));
      out[u] = valid[u] == 0 ? 0 : pixel;
    }
  }
}

}  // namespace gw::frontend

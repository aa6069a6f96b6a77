#include "frontend/core/features/depth_lookup.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gw::frontend {
namespace {

// Pixels within this share of the nearest one lie on the same surface. A plane seen at 75 degrees
// changes by 2 px * tan(75) / 525 px = 1.4 % over the window; Kinect's quantisation is 0.7 % at 4
// m.
constexpr float kSameSurface = 0.03f;
constexpr int kMinPixels = 4;  // of 9, on the surface that is used

}  // namespace

DepthLookup::DepthLookup(const CameraGeometry& geometry)
    : unit_m_(static_cast<float>(geometry.calibration.camera.depth_unit_m)),
      min_m_(static_cast<float>(geometry.rectified.depth_min_m)),
      max_m_(static_cast<float>(geometry.rectified.depth_max_m)) {}

float DepthLookup::At(const ImageView& depth, float u, float v) const {
  const int x = static_cast<int>(std::lround(u));
  const int y = static_cast<int>(std::lround(v));
  if (x < 1 || y < 1 || x >= depth.width - 1 || y >= depth.height - 1) return -1;
  uint16_t pixels[9];
  for (int j = 0; j < 3; ++j) {
    std::memcpy(pixels + 3 * j,
                depth.data + static_cast<ptrdiff_t>(y - 1 + j) * depth.stride + 2 * (x - 1), 6);
  }
  int nearest = 0x10000;
  for (const int p : pixels) {
    if (p > 0) nearest = std::min(nearest, p);
  }
  const int far_end = static_cast<int>(static_cast<float>(nearest) * (1 + kSameSurface));
  int sum = 0;
  int count = 0;
  for (const int p : pixels) {
    if (p <= 0 || p > far_end) continue;
    sum += p;
    ++count;
  }
  if (count < kMinPixels) return -1;
  const float z = unit_m_ * static_cast<float>(sum) / static_cast<float>(count);
  return z >= min_m_ && z <= max_m_ ? z : -1;
}

}  // namespace gw::frontend

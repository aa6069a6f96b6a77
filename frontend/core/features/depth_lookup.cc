#include "frontend/core/features/depth_lookup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace gw::frontend {
namespace {

// Depths that follow each other, in their order, by less than this share lie on the same surface. A
// plane seen at 75 degrees changes by 2 px * tan(75) / 525 px = 1.4 % over the window; Kinect's
// quantisation is 0.7 % at 4 m. (All within a share of the nearest would not do: the noise of nine
// pixels is wider than that beyond 3 m, what is left of them is too near, by 0.5 % at 4 m and 1 %
// at 6 m with a D435's noise, and a third of them is lost.)
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
  std::array<uint16_t, 9> pixels;
  for (int j = 0; j < 3; ++j) {
    std::memcpy(pixels.data() + 3 * j,
                depth.data + static_cast<ptrdiff_t>(y - 1 + j) * depth.stride + 2 * (x - 1), 6);
  }
  std::sort(pixels.begin(), pixels.end());
  int sum = 0;
  int count = 0;
  int last = 0;  // on the nearest surface
  for (const int p : pixels) {
    if (p == 0) continue;
    if (count > 0 && static_cast<float>(p) > static_cast<float>(last) * (1 + kSameSurface)) break;
    sum += p;
    last = p;
    ++count;
  }
  if (count < kMinPixels) return -1;
  const float z = unit_m_ * static_cast<float>(sum) / static_cast<float>(count);
  return z >= min_m_ && z <= max_m_ ? z : -1;
}

}  // namespace gw::frontend

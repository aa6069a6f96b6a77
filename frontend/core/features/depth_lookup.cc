#include "frontend/core/features/depth_lookup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace gw::frontend {
namespace {

// How much a plane may change its depth from one pixel to the next: seen at 75 degrees with a focal
// length of 400 px, tan(75) / 400.
constexpr double kSteepest = 0.01;
// A larger gap between two depths, in standard deviations of one, is hardly noise.
constexpr double kCertainGap = 4;
constexpr int kMinPixels = 4;  // of 9, on the surface that is used

}  // namespace

DepthLookup::DepthLookup(const CameraGeometry& geometry)
    : unit_m_(geometry.calibration.camera.depth_unit_m),
      min_m_(geometry.rectified.depth_min_m),
      noise_per_m_(geometry.rectified.disparity_sigma_px / geometry.rectified.bf()) {}

bool DepthLookup::IsEdge(double near, double far, double pixels) const {
  return far - near > near * (pixels * kSteepest + kCertainGap * noise_per_m_ * near);
}

float DepthLookup::At(const ImageView& depth, float u, float v) const {
  const int x = static_cast<int>(std::lround(u));
  const int y = static_cast<int>(std::lround(v));
  if (x < 1 || y < 1 || x >= depth.width - 1 || y >= depth.height - 1) return -1;
  std::array<uint16_t, 9> pixels;
  auto* row = pixels.data();
  for (int j = -1; j <= 1; ++j, row += 3) {
    std::memcpy(row, depth.data + static_cast<ptrdiff_t>(y + j) * depth.stride + 2 * (x - 1), 6);
  }
  std::sort(pixels.begin(), pixels.end());
  auto p = std::upper_bound(pixels.begin(), pixels.end(), 0);
  const auto front = std::adjacent_find(p, pixels.end(), [this](int near, int far) {
    return IsEdge(unit_m_ * near, unit_m_ * far, 1);
  });
  const auto behind = front == pixels.end() ? front : front + 1;
  const auto count = static_cast<int>(behind - p);
  if (count < kMinPixels) return -1;
  double inverse = 0;
  for (; p != behind; ++p) inverse += 1.0 / *p;
  const double z = unit_m_ * count / inverse;
  return z >= min_m_ ? static_cast<float>(z) : -1;
}

}  // namespace gw::frontend

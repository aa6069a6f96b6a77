#include "tools/data/fault/projector_dots.h"

#include <algorithm>
#include <cmath>

#include "common/core/random.h"

namespace gw::fault {
namespace {

constexpr uint64_t kDotStream = 0xD075;
constexpr double kDotsPerPixel = 420.0 / (480 * 360);
constexpr double kProjector = 0.03;  // m to the right of the left eye
constexpr double kUsualDepth = 1.5;  // m
constexpr int kRadius = 3;           // px, of what is drawn of a dot

void DrawDot(double u, double v, double strength, cv::Mat* image) {
  const int x = static_cast<int>(std::lround(u)), y = static_cast<int>(std::lround(v));
  const cv::Rect whole(0, 0, image->cols, image->rows);
  const cv::Rect around(x - kRadius, y - kRadius, 2 * kRadius + 1, 2 * kRadius + 1);
  const cv::Rect visible = around & whole;
  for (int row = visible.y; row < visible.br().y; ++row) {
    for (int column = visible.x; column < visible.br().x; ++column) {
      const double square = (column - u) * (column - u) + (row - v) * (row - v);
      uint8_t& pixel = image->at<uint8_t>(row, column);
      pixel = cv::saturate_cast<uint8_t>(pixel + strength * std::exp(-square / 2));
    }
  }
}

double DepthAt(const CameraOptics& optics, const CameraImages& images, double u, double v) {
  if (images.depth.empty()) return kUsualDepth;
  const uint16_t units = images.depth.at<uint16_t>(static_cast<int>(v), static_cast<int>(u));
  return units == 0 ? kUsualDepth : units * optics.depth_unit_m;
}

}  // namespace

void DrawProjectorDots(const CameraOptics& optics, CameraImages* images) {
  const int width = images->left.cols, height = images->left.rows;
  const int dots = static_cast<int>(std::lround(kDotsPerPixel * width * height));
  for (int i = 0; i < dots; ++i) {
    CounterRng rng(0, kDotStream, static_cast<uint64_t>(i));
    const double u = rng.Uniform(0, width), v = rng.Uniform(0, height);
    const double z = DepthAt(optics, *images, u, v);
    // Near surfaces give more light back; far dots stay above the noise, near ones below white.
    const double strength = std::clamp(160 / std::max(z, 0.8), 25.0, 110.0);
    const double shift_px = optics.fx_px * kProjector / z;
    DrawDot(u + shift_px, v, strength, &images->left);
    if (images->right.empty()) continue;
    DrawDot(u + shift_px - optics.fx_px * optics.baseline_m / z, v, strength, &images->right);
  }
}

}  // namespace gw::fault

#include "tools/sim/sim/depth_sensor.h"

#include <algorithm>
#include <cmath>

#include "tools/sim/sim/noise_hash.h"

namespace gw::sim {
namespace {

constexpr int kRowsPerPiece = 16;
constexpr int kWindow = 3;      // px on each side: texture that a match looks at
constexpr float kJump = 0.05f;  // relative change of the depth that makes an edge
constexpr int kEdge = 2;        // px

// Mean gradient along x in the window around every pixel of row y; the disparity is found from it.
void Contrast(const std::vector<float>& signal, int width, int height, int y,
              std::vector<float>* columns, std::vector<float>* out) {
  std::fill(columns->begin(), columns->end(), 0.0f);
  const int y0 = std::max(0, y - kWindow), y1 = std::min(height - 1, y + kWindow);
  for (int yy = y0; yy <= y1; ++yy) {
    const float* row = signal.data() + static_cast<size_t>(yy) * width;
    for (int x = 1; x + 1 < width; ++x) (*columns)[x] += std::abs(row[x + 1] - row[x - 1]);
  }
  const float scale = 1.0f / static_cast<float>((y1 - y0 + 1) * (2 * kWindow + 1));
  for (int x = 0; x < width; ++x) {
    float sum = 0;
    for (int xx = std::max(0, x - kWindow); xx <= std::min(width - 1, x + kWindow); ++xx) {
      sum += (*columns)[xx];
    }
    (*out)[x] = sum * scale;
  }
}

}  // namespace

double DepthSigma(const DepthConfig& config, double fx, double z) {
  const double disparity_variance = config.disparity_sigma_px * config.disparity_sigma_px +
                                    config.disparity_step_px * config.disparity_step_px / 12;
  return z * z / (fx * config.baseline_m) * std::sqrt(disparity_variance);
}

void MeasureDepth(const RenderedImage& scene, const std::vector<float>& signal,
                  const Pinhole& camera, const DepthConfig& config, uint64_t noise_key,
                  WorkerPool* pool, std::vector<uint16_t>* depth) {
  const int width = camera.width;
  const int height = camera.height;
  depth->assign(static_cast<size_t>(width) * height, 0);
  const auto bf = static_cast<float>(camera.fx * config.baseline_m);
  const auto min_disparity = static_cast<float>(bf / config.max_m);
  const auto max_disparity = static_cast<float>(bf / config.min_m);
  const auto sigma = static_cast<float>(config.disparity_sigma_px);
  const auto step = static_cast<float>(config.disparity_step_px);
  const auto key = static_cast<uint32_t>(noise_key ^ (noise_key >> 32));
  const int pieces = (height + kRowsPerPiece - 1) / kRowsPerPiece;
  pool->Run(pieces, [&](int piece, int) {
    std::vector<float> columns(width), contrast(width);
    const int end = std::min(height, (piece + 1) * kRowsPerPiece);
    for (int y = piece * kRowsPerPiece; y < end; ++y) {
      Contrast(signal, width, height, y, &columns, &contrast);
      const float* w = scene.inverse_depth.data() + static_cast<size_t>(y) * width;
      uint16_t* out = depth->data() + static_cast<size_t>(y) * width;
      float leftmost = 1e9f;  // of the right eye's columns covered so far, from the right
      for (int x = width - 1; x >= 0; --x) {
        const float right_x = static_cast<float>(x) - bf * w[x];
        const bool hidden = right_x >= leftmost;
        leftmost = std::min(leftmost, right_x);
        const float before = w[std::max(0, x - kEdge)];
        const float after = w[std::min(width - 1, x + kEdge)];
        const bool edge = std::abs(before - after) > kJump * std::max(before, after) &&
                          std::abs(before - 2 * w[x] + after) > 0.25f * std::abs(before - after);
        if (hidden || edge || right_x < 0 ||
            contrast[x] < static_cast<float>(config.min_contrast_grey)) {
          continue;
        }
        // Half of the variance is common to 4 x 4 pixels: neighbours share most of their window.
        const uint32_t pixel = static_cast<uint32_t>(y) * width + x;
        const uint32_t block = static_cast<uint32_t>(y / 4) * 0x10001u + x / 4 + 0x8000000u;
        const float noise =
            0.70710678f * (UnitNoise(HashPixel(pixel, key)) + UnitNoise(HashPixel(block, key)));
        const float disparity = std::round((bf * w[x] + sigma * noise) / step) * step;
        if (disparity < min_disparity || disparity > max_disparity) continue;
        out[x] =
            static_cast<uint16_t>(std::min(65535.0, std::round(bf / disparity / config.unit_m)));
      }
    }
  });
}

}  // namespace gw::sim

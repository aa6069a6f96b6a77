// Rendered textures for tests and benchmarks: exact at any position and scale, unlike a resized
// photograph.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include "common/core/random.h"
#include "frontend/core/features/image_buffer.h"

namespace gw::frontend {

// The plane cut into random cells (Voronoi cells of a jittered grid) of one grey value each: many
// corners of all angles and contrasts.
class CellTexture {
 public:
  // cell: mean size of a cell; contrast: grey values lie within 128 +- contrast / 2.
  CellTexture(uint64_t seed, double cell, double contrast = 200)
      : seed_(seed), cell_(cell), contrast_(contrast) {}

  double At(double x, double y) const {
    const double gx = x / cell_;
    const double gy = y / cell_;
    const int64_t cx = static_cast<int64_t>(std::floor(gx));
    const int64_t cy = static_cast<int64_t>(std::floor(gy));
    double best = 1e9;
    double value = 0;
    for (int64_t j = cy - 1; j <= cy + 1; ++j) {
      for (int64_t i = cx - 1; i <= cx + 1; ++i) {
        CounterRng rng(seed_, static_cast<uint64_t>(i + (1 << 20)),
                       static_cast<uint64_t>(j + (1 << 20)));
        const double sx = static_cast<double>(i) + rng.Uniform();
        const double sy = static_cast<double>(j) + rng.Uniform();
        const double d = (sx - gx) * (sx - gx) + (sy - gy) * (sy - gy);
        if (d >= best) continue;
        best = d;
        value = rng.Uniform();
      }
    }
    return 128 + contrast_ * (value - 0.5);
  }

 private:
  uint64_t seed_;
  double cell_, contrast_;
};

// An image whose pixel (u, v) is the mean of texture.At(to_texture(u', v')) over the pixel's area
// (4x4 samples), plus Gaussian noise of `noise` grey levels.
inline ImageBuffer Render(const CellTexture& texture, int width, int height,
                          const std::function<Eigen::Vector2d(double, double)>& to_texture,
                          double noise = 0, uint64_t noise_seed = 0) {
  constexpr int kSamples = 4;
  ImageBuffer image;
  image.Resize(width, height, width);
  CounterRng rng(noise_seed, 1, 1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      double sum = 0;
      for (int j = 0; j < kSamples; ++j) {
        for (int i = 0; i < kSamples; ++i) {
          const Eigen::Vector2d p =
              to_texture(u - 0.5 + (i + 0.5) / kSamples, v - 0.5 + (j + 0.5) / kSamples);
          sum += texture.At(p.x(), p.y());
        }
      }
      const double value = sum / (kSamples * kSamples) + (noise > 0 ? noise * rng.Normal() : 0.0);
      image.row(v)[u] = static_cast<uint8_t>(std::clamp(std::lround(value), 0l, 255l));
    }
  }
  return image;
}

}  // namespace gw::frontend

#include "test/emulators/camera/dot_projector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/core/random.h"

namespace gw::camera {

void ProjectDots(const DotProjector& projector, uint64_t seed, int width, int height,
                 const std::vector<float>& inverse_depth, std::vector<float>* radiance) {
  const std::vector<float> surface = *radiance;
  const double shift_px_m = projector.fx * projector.offset_m;
  const int columns = static_cast<int>(2 * width / projector.pitch_px);
  const int rows = static_cast<int>(height / projector.pitch_px);
  const int reach = static_cast<int>(std::ceil(3 * projector.sigma_px));
  for (int i = 0; i < columns * rows; ++i) {
    CounterRng rng(seed, 3, static_cast<uint64_t>(i));
    // The dot's place in the image of an eye at the projector's place; the pattern is wider than
    // the image.
    const double u = (i % columns + rng.Uniform()) * projector.pitch_px - width / 2.;
    const double v = (static_cast<int>(i / columns) + rng.Uniform()) * projector.pitch_px;
    const int y = static_cast<int>(std::lround(v));
    if (y < 0 || y >= height) continue;
    // The place where the dot falls depends on the depth there: the nearest surface on its way
    // wins.
    double best_x = -1, best_w = 0;
    for (int x = 0; x < width; ++x) {
      const double w = inverse_depth[static_cast<size_t>(y) * width + x];
      if (w > best_w && std::abs(u + shift_px_m * w - x) < 0.75) {
        best_x = u + shift_px_m * w;
        best_w = w;
      }
    }
    if (best_w <= 0) continue;
    const int middle = static_cast<int>(std::lround(best_x));
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const int px = middle + dx, py = y + dy;
        if (px < 0 || py < 0 || px >= width || py >= height) continue;
        const size_t at = static_cast<size_t>(py) * width + px;
        const double distance2 = (px - best_x) * (px - best_x) + (py - v) * (py - v);
        const double albedo = std::min(1.0, static_cast<double>(surface[at]));
        (*radiance)[at] += static_cast<float>(
            projector.radiance_at_1m * albedo * best_w * best_w *
            std::exp(-distance2 / (2 * projector.sigma_px * projector.sigma_px)));
      }
    }
  }
}

}  // namespace gw::camera

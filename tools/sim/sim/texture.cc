#include "tools/sim/sim/texture.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace gw::sim {

Texture::Texture(int width, int height, const std::vector<float>& reflectance) {
  GW_CHECK(width > 0 && height > 0 && (width & (width - 1)) == 0 && (height & (height - 1)) == 0);
  GW_CHECK(reflectance.size() == static_cast<size_t>(width) * height);
  std::vector<float> values = reflectance;
  float scale = 1;
  while (true) {
    Level level;
    level.width = width;
    level.height = height;
    level.scale = scale;
    while ((1 << level.shift) < width) ++level.shift;
    level.texels.resize(values.size());
    std::transform(values.begin(), values.end(), level.texels.begin(), [](float value) {
      return static_cast<uint16_t>(std::lround(65535.0f * std::clamp(value, 0.0f, 1.0f)));
    });
    levels_.push_back(std::move(level));
    if (width == 1 || height == 1) break;
    std::vector<float> half(values.size() / 4);
    for (int y = 0; y < height / 2; ++y) {
      for (int x = 0; x < width / 2; ++x) {
        const float* a = &values[static_cast<size_t>(2 * y) * width + 2 * x];
        half[static_cast<size_t>(y) * (width / 2) + x] =
            0.25f * (a[0] + a[1] + a[width] + a[width + 1]);
      }
    }
    values = std::move(half);
    width /= 2;
    height /= 2;
    scale *= 0.5f;
  }
}

}  // namespace gw::sim

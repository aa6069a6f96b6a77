#include "frontend/core/features/image_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

ImageBuffer RandomImage(int width, int height, uint64_t seed) {
  ImageBuffer image;
  image.Resize(width, height, width);
  CounterRng rng(seed, 0, 0);
  for (uint8_t& p : image.pixels) p = static_cast<uint8_t>(rng.Below(256));
  return image;
}

double Pixel(const ImageBuffer& image, int x, int y) {
  return image.row(std::clamp(y, 0, image.height - 1))[std::clamp(x, 0, image.width - 1)];
}

TEST(BinomialFilter, IsTheConvolutionWithRepeatedBorders) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    CounterRng rng(seed, 1, 0);
    const ImageBuffer input =
        RandomImage(1 + static_cast<int>(rng.Below(70)), 1 + static_cast<int>(rng.Below(20)), seed);
    ImageBuffer output;
    BinomialFilter filter;
    filter.Apply(input.View(), &output);
    ASSERT_EQ(output.width, input.width);
    ASSERT_EQ(output.height, input.height);
    for (int y = 0; y < input.height; ++y) {
      for (int x = 0; x < input.width; ++x) {
        double sum = 0;
        for (int j = -1; j <= 1; ++j) {
          for (int i = -1; i <= 1; ++i) {
            sum += (2 - std::abs(i)) * (2 - std::abs(j)) * Pixel(input, x + i, y + j);
          }
        }
        EXPECT_NEAR(output.row(y)[x], sum / 16, 0.5) << seed;
      }
    }
  }
}

TEST(BilinearResizer, InterpolatesAtThePixelCentresOfTheOutput) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    CounterRng rng(seed, 2, 0);
    const double factor = rng.Uniform(1.0, 2.0);
    const int width = 2 + static_cast<int>(rng.Below(90));
    const int height = 2 + static_cast<int>(rng.Below(30));
    const ImageBuffer input = RandomImage(width, height, seed);
    const int output_width = static_cast<int>(std::ceil(width / factor));
    const int output_height = static_cast<int>(std::ceil(height / factor));
    ImageBuffer output;
    output.Resize(output_width, output_height, output_width + 16);
    BilinearResizer resizer(width, height, output_width, output_height);
    resizer.Apply(input, &output);
    for (int y = 0; y < output_height; ++y) {
      for (int x = 0; x < output_width; ++x) {
        const double sx = std::clamp((x + 0.5) * width / output_width - 0.5, 0.0, width - 1.0);
        const double sy = std::clamp((y + 0.5) * height / output_height - 0.5, 0.0, height - 1.0);
        const int x0 = static_cast<int>(sx);
        const int y0 = static_cast<int>(sy);
        const double a = sx - x0;
        const double b = sy - y0;
        const double expected =
            (1 - b) * ((1 - a) * Pixel(input, x0, y0) + a * Pixel(input, x0 + 1, y0)) +
            b * ((1 - a) * Pixel(input, x0, y0 + 1) + a * Pixel(input, x0 + 1, y0 + 1));
        // Positions are rounded to 1/64 px: at most 255 / 128 per axis, and half a grey level.
        EXPECT_NEAR(output.row(y)[x], expected, 2 * 255.0 / 128 + 0.5) << seed;
      }
    }
  }
}

}  // namespace
}  // namespace gw::frontend

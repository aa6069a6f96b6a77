#include "frontend/core/features/orb_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "common/core/random.h"
#include "frontend/core/features/image_filter.h"
#include "frontend/core/features/image_test_pattern.h"

namespace gw::frontend {
namespace {

ImageBuffer Texture(uint64_t seed, double contrast) {
  ImageBuffer image = Render(
      CellTexture(seed, 9, contrast), 150, 110,
      [](double u, double v) { return Eigen::Vector2d(u, v); }, 2, seed);
  return image;
}

// By definition: the largest t for which nine neighbouring pixels of the circle differ from the
// centre by at least t, all to the same side.
int SlowScore(const ImageBuffer& image, int x, int y) {
  constexpr std::array<std::array<int, 2>, 16> kCircle = {{{0, -3},
                                                           {1, -3},
                                                           {2, -2},
                                                           {3, -1},
                                                           {3, 0},
                                                           {3, 1},
                                                           {2, 2},
                                                           {1, 3},
                                                           {0, 3},
                                                           {-1, 3},
                                                           {-2, 2},
                                                           {-3, 1},
                                                           {-3, 0},
                                                           {-3, -1},
                                                           {-2, -2},
                                                           {-1, -3}}};
  for (int t = 255; t > 0; --t) {
    for (const int side : {1, -1}) {
      int run = 0;
      for (size_t i = 0; i < 32; ++i) {
        const auto& offset = kCircle[i % 16];
        const int difference =
            image.row(y + offset[1])[x + offset[0]] - static_cast<int>(image.row(y)[x]);
        run = side * difference >= t ? run + 1 : 0;
        if (run == 9) return t;
      }
    }
  }
  return 0;
}

TEST(OrbDetector, FindsExactlyTheLocalMaximaOfTheFastScore) {
  constexpr int kBorder = 16;
  constexpr int kThreshold = 12;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const ImageBuffer image = Texture(seed, 120);
    OrbDetector detector(kThreshold, kThreshold, kBorder);
    std::vector<Corner> corners;
    detector.Detect(image, &corners);
    size_t next = 0;
    const auto score = [&](int x, int y) {
      const int s = SlowScore(image, x, y);
      return s > kThreshold ? s : 0;
    };
    for (int y = kBorder; y < image.height - kBorder; ++y) {
      for (int x = kBorder; x < image.width - kBorder; ++x) {
        const int s = score(x, y);
        if (s == 0) continue;
        bool peak = true;
        for (int i = 0; i < 9; ++i) {
          const int other = score(x + i % 3 - 1, y + i / 3 - 1);
          if (i < 4 ? other >= s : i > 4 && other > s) peak = false;
        }
        if (!peak) continue;
        ASSERT_LT(next, corners.size());
        EXPECT_EQ(corners[next].x, x);
        EXPECT_EQ(corners[next].y, y);
        EXPECT_EQ(corners[next].score, s);
        EXPECT_EQ(FastScore(image, x, y), s);
        ++next;
      }
    }
    EXPECT_EQ(next, corners.size());
    EXPECT_GT(next, 20u);
  }
}

TEST(OrbDetector, AsksForLessContrastOnlyWhereThereAreTooFewCorners) {
  // Strong texture on the left, weak on the right.
  const CellTexture strong(1, 9, 200), weak(2, 9, 40);
  ImageBuffer image;
  image.Resize(320, 200, 320);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      image.row(y)[x] = static_cast<uint8_t>(std::lround((x < 160 ? strong : weak).At(x, y)));
    }
  }
  OrbDetector detector(40, 7, 16);
  std::vector<Corner> corners;
  detector.Detect(image, &corners);
  int strong_left = 0;
  int weak_left = 0;
  int weak_right = 0;
  for (const Corner& c : corners) {
    if (c.x < 140) ++(c.score > 40 ? strong_left : weak_left);
    if (c.x > 200) ++weak_right;
  }
  EXPECT_GT(strong_left, 30);
  EXPECT_EQ(weak_left, 0);
  EXPECT_GT(weak_right, 30);
}

TEST(OrbDetector, FindsNothingInAnImageSmallerThanItsBorders) {
  ImageBuffer image;
  image.Resize(32, 32, 48);
  std::vector<Corner> corners = {Corner{}};
  OrbDetector(20, 7, 16).Detect(image, &corners);
  EXPECT_TRUE(corners.empty());
}

TEST(RefineCorner, FollowsAShiftOfAFractionOfAPixel) {
  double sum = 0;
  double sum_squared = 0;
  double whole_squared = 0;
  int count = 0;
  for (const double shift : {0.25, 0.5, 0.75}) {
    const CellTexture texture(5, 14);
    const auto render = [&](double s) {
      const ImageBuffer raw =
          Render(texture, 320, 240, [s](double u, double v) { return Eigen::Vector2d(u - s, v); });
      // As smooth as a pyramid level.
      ImageBuffer once, twice;
      BinomialFilter filter;
      filter.Apply(raw.View(), &once);
      filter.Apply(once.View(), &twice);
      return twice;
    };
    const ImageBuffer still = render(0);
    const ImageBuffer moved = render(shift);
    OrbDetector detector(15, 15, 16);
    std::vector<Corner> a, b;
    detector.Detect(still, &a);
    detector.Detect(moved, &b);
    for (const Corner& c : a) {
      for (const Corner& d : b) {
        if (std::abs(d.x - c.x) > 1 || std::abs(d.y - c.y) > 1) continue;
        const double error =
            d.x + RefineCorner(moved, d.x, d.y).dx - c.x - RefineCorner(still, c.x, c.y).dx - shift;
        const double whole_error = d.x - c.x - shift;
        whole_squared += whole_error * whole_error;
        sum += error;
        sum_squared += error * error;
        ++count;
      }
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_NEAR(sum / count, 0, 0.05);
  EXPECT_LT(std::sqrt(sum_squared), 0.75 * std::sqrt(whole_squared))
      << std::sqrt(sum_squared / count) << ' ' << std::sqrt(whole_squared / count);
}

// Edges of all directions with noise lie below what the extractor asks for, corners of all
// directions above.
TEST(CornerRatio, TellsEdgesFromCorners) {
  constexpr int kSize = 31;
  constexpr int kMiddle = kSize / 2;
  CounterRng rng(3, 0, 0);
  for (int step = 0; step < 36; ++step) {
    const double angle = step * 10 * M_PI / 180;
    const double nx = std::cos(angle);
    const double ny = std::sin(angle);
    ImageBuffer edge;
    ImageBuffer corner;
    edge.Resize(kSize, kSize, kSize);
    corner.Resize(kSize, kSize, kSize);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double a = nx * (x - kMiddle) + ny * (y - kMiddle);
        const double b = -ny * (x - kMiddle) + nx * (y - kMiddle);
        const auto soft = [](double d) { return std::clamp(0.5 + 0.5 * d, 0.0, 1.0); };
        const double noise = 1.5 * rng.Normal();
        edge.row(y)[x] = static_cast<uint8_t>(std::lround(100 + 60 * soft(a) + noise));
        corner.row(y)[x] = static_cast<uint8_t>(std::lround(100 + 60 * soft(a) * soft(b) + noise));
      }
    }
    EXPECT_LT(CornerRatio(edge, kMiddle, kMiddle), 0.05) << step;
    EXPECT_GT(CornerRatio(corner, kMiddle, kMiddle), 0.25) << step;
  }
}

TEST(CornerRatio, IsZeroWhereThereIsNothing) {
  ImageBuffer flat;
  flat.Resize(16, 16, 16);
  std::fill(flat.pixels.begin(), flat.pixels.end(), uint8_t{90});
  EXPECT_EQ(CornerRatio(flat, 8, 8), 0);
}

}  // namespace
}  // namespace gw::frontend

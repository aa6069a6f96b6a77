#include "frontend/core/features/disparity_refiner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "frontend/core/features/image_test_pattern.h"

namespace gw::frontend {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 160;
constexpr double kNoise = 1.5;  // grey values

// A surface whose disparity is d + along * u + across * v.
struct Surface {
  double d = 0;
  double along = 0;
  double across = 0;
  double At(double u, double v) const { return d + along * u + across * v; }
};

struct Pair {
  ImageBuffer left, right;
};

// What the two eyes see of it, the right one `brighter` by so many grey values.
Pair See(const Surface& s, uint64_t seed, int brighter = 0) {
  const CellTexture texture(seed, 6, 120);
  Pair pair;
  pair.left = Render(
      texture, kWidth, kHeight, [](double u, double v) { return Eigen::Vector2d(u, v); }, kNoise,
      seed);
  pair.right = Render(
      texture, kWidth, kHeight,
      [&s](double u, double v) {
        return Eigen::Vector2d((u + s.d + s.across * v) / (1 - s.along), v);
      },
      kNoise, seed + 1000);
  for (uint8_t& p : pair.right.pixels) p = static_cast<uint8_t>(p + brighter);
  return pair;
}

struct Errors {
  int found = 0, all = 0;
  double mean = 0, rms = 0;
};

// Over a grid of points between pixels, started `off` px beside the truth.
Errors Measure(const Pair& pair, const Surface& s, double off) {
  Errors e;
  for (double v = 12.3; v < kHeight - 14; v += 7.37) {
    for (double u = 40.1; u < kWidth - 30; u += 8.71) {
      ++e.all;
      const std::optional<float> d =
          RefineDisparity(pair.left, pair.right, static_cast<float>(u), static_cast<float>(v),
                          static_cast<float>(s.At(u, v) + off));
      if (!d) continue;
      ++e.found;
      const double error = *d - s.At(u, v);
      e.mean += error;
      e.rms += error * error;
    }
  }
  e.mean /= e.found;
  e.rms = std::sqrt(e.rms / e.found);
  return e;
}

TEST(DisparityRefiner, IsNotDrawnToWholePixels) {
  for (int k = 0; k < 8; ++k) {
    const Surface wall{8 + k / 8.0, 0, 0};
    const Errors e = Measure(See(wall, static_cast<uint64_t>(k) + 1), wall, 0.3);
    EXPECT_GT(e.found, 0.9 * e.all) << wall.d;
    EXPECT_NEAR(e.mean, 0, 0.02) << wall.d;
    EXPECT_LT(e.rms, 0.06) << wall.d;
  }
}

TEST(DisparityRefiner, FollowsSlantedSurfaces) {
  const Surface floor{2, 0, 0.2};
  const Surface wall{20, -0.1, 0};
  for (const Surface& s : {floor, wall}) {
    const Errors e = Measure(See(s, 3), s, -0.3);
    EXPECT_GT(e.found, 0.85 * e.all) << s.along;
    EXPECT_NEAR(e.mean, 0, 0.02) << s.along;
    EXPECT_LT(e.rms, 0.08) << s.along;
  }
}

TEST(DisparityRefiner, DoesNotMindTheExposure) {
  const Surface wall{8.4, 0, 0};
  const Errors e = Measure(See(wall, 4, 25), wall, 0.3);
  EXPECT_GT(e.found, 0.9 * e.all);
  EXPECT_NEAR(e.mean, 0, 0.02);
}

TEST(DisparityRefiner, RefusesWhatHasNoStructureOrLiesAtTheBorder) {
  ImageBuffer flat;
  flat.Resize(kWidth, kHeight, kWidth);
  std::fill(flat.pixels.begin(), flat.pixels.end(), uint8_t{90});
  EXPECT_FALSE(RefineDisparity(flat, flat, 80, 60, 5).has_value());

  const Pair pair = See({8, 0, 0}, 5);
  EXPECT_TRUE(RefineDisparity(pair.left, pair.right, 80, 60, 8).has_value());
  for (const auto& [u, v] : std::vector<std::pair<float, float>>{
           {5, 60}, {13, 60}, {kWidth - 6, 60}, {80, 4}, {80, kHeight - 5}, {-50, 60}, {80, 500}}) {
    EXPECT_FALSE(RefineDisparity(pair.left, pair.right, u, v, 8).has_value()) << u << " " << v;
  }
  EXPECT_FALSE(RefineDisparity(pair.left, pair.right, 80, 60, NAN).has_value());
}

// What comes back is near the estimate and fits; a wrong estimate is mostly noticed.
TEST(DisparityRefiner, StaysNearTheEstimate) {
  const Surface wall{12.6, 0, 0};
  const Pair pair = See(wall, 6);
  int wrong = 0;
  int all = 0;
  for (float u = 50; u < 160; u += 5.3F) {
    const std::optional<float> d = RefineDisparity(pair.left, pair.right, u, 70.2F, 17.0F);
    ++all;
    if (!d) continue;
    EXPECT_NEAR(*d, 17, 2.5);
    ++wrong;
  }
  EXPECT_LT(wrong, 0.4 * all);
}

}  // namespace
}  // namespace gw::frontend

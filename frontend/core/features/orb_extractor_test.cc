#include "frontend/core/features/orb_extractor.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "frontend/core/features/image_test_pattern.h"

namespace gw::frontend {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

struct Features {
  std::vector<OrbKeypoint> keypoints;
  std::vector<Descriptor> descriptors;
};

Features Extract(const ImageBuffer& image, const OrbConfig& config = {}) {
  OrbExtractor extractor = OrbExtractor::Create(config, image.width, image.height).value();
  Features out;
  extractor.Extract(image.View(), nullptr, &out.keypoints, &out.descriptors);
  return out;
}

// Takes a pixel of the second image to its place in the first.
using Warp = std::function<Eigen::Vector2d(double, double)>;

TEST(OrbExtractor, DescriptorsOfATurnedImageMatch) {
  const CellTexture texture(1, 16);
  const ImageBuffer upright = Render(
      texture, kWidth, kHeight, [](double u, double v) { return Eigen::Vector2d(u, v); }, 2, 1);
  const Features a = Extract(upright);
  for (const double degrees : {17.0, 45.0, 90.0, 133.0, 180.0, 260.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Eigen::Rotation2Dd turn(angle);
    const Eigen::Vector2d center(0.5 * (kWidth - 1), 0.5 * (kHeight - 1));
    const Warp warp = [&](double u, double v) -> Eigen::Vector2d {
      return turn * (Eigen::Vector2d(u, v) - center) + center;
    };
    const Features b = Extract(Render(texture, kWidth, kHeight, warp, 2, 2));
    int pairs = 0;
    int matching = 0;
    int nearest = 0;
    double angle_error = 0;
    for (size_t j = 0; j < b.keypoints.size(); ++j) {
      const OrbKeypoint& q = b.keypoints[j];
      const Eigen::Vector2d p = warp(q.u, q.v);
      int best_distance = 257;
      bool best_is_right = false;
      bool has_partner = false;
      for (size_t i = 0; i < a.keypoints.size(); ++i) {
        const OrbKeypoint& k = a.keypoints[i];
        const bool same = k.level == q.level &&
                          (Eigen::Vector2d(k.u, k.v) - p).norm() < 1.0 * std::pow(1.2, k.level);
        const int distance = HammingDistance(a.descriptors[i], b.descriptors[j]);
        if (same) {
          has_partner = true;
          matching += distance < 64;
          // The patch turned by -angle.
          const double error = std::remainder(k.angle - q.angle - angle, 2 * std::numbers::pi);
          angle_error += std::abs(error);
          ++pairs;
        }
        if (distance < best_distance) {
          best_distance = distance;
          best_is_right = (Eigen::Vector2d(k.u, k.v) - p).norm() < 3 * std::pow(1.2, k.level);
        }
      }
      nearest += has_partner && best_is_right;
    }
    EXPECT_GT(pairs, 150) << degrees;
    EXPECT_GT(matching, 0.9 * pairs) << degrees;
    EXPECT_GT(nearest, 0.9 * pairs) << degrees;
    EXPECT_LT(angle_error / pairs, 0.1) << degrees;
  }
}

TEST(OrbExtractor, PutsLevelsWhereTheImageIs) {
  // The second image shows the same, magnified by four levels: a corner of level l moves to level
  // l + 4. Taking x * scale for the place of a pixel would shift it by (1 - 1 / zoom) / 2 = 0.26
  // px.
  const CellTexture texture(2, 12);
  constexpr int kLevels = 4;
  const double zoom = std::pow(1.2, kLevels);
  OrbConfig config;
  config.num_features = 2000;
  const Features a = Extract(
      Render(texture, kWidth, kHeight, [](double u, double v) { return Eigen::Vector2d(u, v); }),
      config);
  const Warp warp = [zoom](double u, double v) {
    return Eigen::Vector2d((u + 0.5) / zoom - 0.5, (v + 0.5) / zoom - 0.5);
  };
  const Features b = Extract(Render(texture, kWidth, kHeight, warp), config);
  for (int level = 0; level < 4; ++level) {
    Eigen::Vector2d sum(0, 0);
    int count = 0;
    for (size_t i = 0; i < a.keypoints.size(); ++i) {
      if (a.keypoints[i].level != level) continue;
      for (size_t j = 0; j < b.keypoints.size(); ++j) {
        if (b.keypoints[j].level != level + kLevels) continue;
        const Eigen::Vector2d error = warp(b.keypoints[j].u, b.keypoints[j].v) -
                                      Eigen::Vector2d(a.keypoints[i].u, a.keypoints[i].v);
        if (error.norm() > std::pow(1.2, level)) continue;
        if (HammingDistance(a.descriptors[i], b.descriptors[j]) > 60) continue;
        sum += error;
        ++count;
      }
    }
    ASSERT_GT(count, 15) << level;
    EXPECT_LT((sum / count).cwiseAbs().maxCoeff(), 0.1)
        << level << ": " << (sum / count).transpose();
  }
}

TEST(OrbExtractor, SpreadsFeaturesEvenlyOverAnEvenTexture) {
  const Features f = Extract(Render(CellTexture(3, 9), kWidth, kHeight,
                                    [](double u, double v) { return Eigen::Vector2d(u, v); }));
  EXPECT_EQ(f.keypoints.size(), 800u);
  std::array<int, 16> count{};
  for (const OrbKeypoint& k : f.keypoints) {
    ++count[static_cast<size_t>(static_cast<int>(k.v) / 120 * 4 + static_cast<int>(k.u) / 160)];
  }
  // 50 on average; the rim of coarse levels stays empty.
  EXPECT_GE(*std::min_element(count.begin(), count.end()), 20);
  EXPECT_LE(*std::max_element(count.begin(), count.end()), 110);
}

TEST(OrbExtractor, KeepsFeaturesInTheWeakHalfOfAnUnevenTexture) {
  const CellTexture strong(4, 9, 220), weak(5, 12, 60);
  ImageBuffer image;
  image.Resize(kWidth, kHeight, kWidth);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image.row(y)[x] =
          static_cast<uint8_t>(std::lround((x < kWidth / 2 ? strong : weak).At(x, y)));
    }
  }
  const Features f = Extract(image);
  const auto weak_side = std::count_if(f.keypoints.begin(), f.keypoints.end(),
                                       [](const OrbKeypoint& k) { return k.u > kWidth / 2; });
  EXPECT_GT(weak_side, 200);
}

TEST(OrbExtractor, FindsLowContrastWithTheLowThresholdOnly) {
  const ImageBuffer faint = Render(CellTexture(6, 12, 50), kWidth, kHeight,
                                   [](double u, double v) { return Eigen::Vector2d(u, v); });
  OrbConfig high_only;
  high_only.fast_threshold_low = high_only.fast_threshold;
  EXPECT_GT(Extract(faint).keypoints.size(), 700u);
  EXPECT_LT(Extract(faint, high_only).keypoints.size(), 400u);
}

TEST(OrbExtractor, LeavesOutWhatReachesPixelsWithoutContent) {
  const ImageBuffer image = Render(CellTexture(7, 9), kWidth, kHeight,
                                   [](double u, double v) { return Eigen::Vector2d(u, v); });
  // No content to the left of column 200.
  ImageBuffer valid;
  valid.Resize(kWidth, kHeight, kWidth);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      valid.row(y)[x] = static_cast<uint8_t>(std::clamp(x - 199, 0, 255));
    }
  }
  OrbExtractor extractor = OrbExtractor::Create({}, kWidth, kHeight).value();
  Features f;
  extractor.Extract(image.View(), &valid, &f.keypoints, &f.descriptors);
  EXPECT_GT(f.keypoints.size(), 780u);  // of 800; what turns out to be an edge is dropped
  for (const OrbKeypoint& k : f.keypoints) {
    EXPECT_GT(k.u, 199 + kOrbPatchRadius * std::pow(1.2, k.level));
  }
}

TEST(OrbExtractor, WorksOnImagesTooSmallForAllLevels) {
  for (const auto& [width, height] : {std::pair{64, 64}, {33, 33}, {200, 40}}) {
    const ImageBuffer image = Render(CellTexture(8, 5), width, height,
                                     [](double u, double v) { return Eigen::Vector2d(u, v); });
    const Features f = Extract(image);
    for (const OrbKeypoint& k : f.keypoints) {
      EXPECT_GE(k.u, 0);
      EXPECT_LT(k.u, width);
      EXPECT_GE(k.v, 0);
      EXPECT_LT(k.v, height);
    }
  }
  EXPECT_FALSE(OrbExtractor::Create({}, 32, 32).ok());
}

}  // namespace
}  // namespace gw::frontend

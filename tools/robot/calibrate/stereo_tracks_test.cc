#include "tools/robot/calibrate/stereo_tracks.h"

#include <gtest/gtest.h>

#include "frontend/core/features/image_test_pattern.h"

namespace gw::tools {
namespace {

using frontend::CellTexture;
using frontend::ImageBuffer;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kDisparity = 7.25;

ImageBuffer Eye(double x, double y, uint64_t seed = 3) {
  const CellTexture texture(seed, 12);
  return frontend::Render(
      texture, kWidth, kHeight,
      [x, y](double u, double v) { return Eigen::Vector2d(u + x, v + y); }, 1.0, seed);
}

std::optional<PairTracks> Push(StereoTracker& tracker, double x, double y, uint64_t seed = 3) {
  return tracker.Push(Eye(x, y, seed).View(), Eye(x + kDisparity, y, seed).View());
}

TEST(StereoTracker, FollowsCornersToTheSubpixelOnceTheImageMoved) {
  StereoTracker tracker;
  EXPECT_FALSE(Push(tracker, 0, 0));      // the first pair
  EXPECT_FALSE(Push(tracker, 2.5, 0.5));  // not far enough; the first pair stays
  const auto tracks = Push(tracker, 9.3, 3.6);
  ASSERT_TRUE(tracks);
  ASSERT_GT(tracks->size(), 60U);
  double worst = 0;
  for (const StereoTrack& t : *tracks) {
    for (const auto& error :
         {Eigen::Vector2d(t.left0 - t.right0 - Eigen::Vector2d(kDisparity, 0)),
          Eigen::Vector2d(t.left0 - t.left1 - Eigen::Vector2d(9.3, 3.6)),
          Eigen::Vector2d(t.left1 - t.right1 - Eigen::Vector2d(kDisparity, 0))}) {
      worst = std::max(worst, error.norm());
    }
  }
  EXPECT_LT(worst, 0.35);
}

TEST(StereoTracker, StartsAnewWhenTheSceneIsLost) {
  StereoTracker tracker;
  EXPECT_FALSE(Push(tracker, 0, 0));
  EXPECT_FALSE(Push(tracker, 0, 0, 99));  // another scene
  const auto tracks = Push(tracker, 8, 0, 99);
  ASSERT_TRUE(tracks);
  EXPECT_NEAR(tracks->front().left0.x() - tracks->front().left1.x(), 8, 0.3);
}

}  // namespace
}  // namespace gw::tools

#include "backend/core/bundle/floor_level.h"

#include <gtest/gtest.h>

namespace gw::backend {
namespace {

// T_BC of a camera 0.3 m above the base, looking ahead.
const SE3 kCamera(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.3});

// Keyframes in a row, one a second and one a metre, that see nothing.
class Drive {
 public:
  const Map& map() const { return map_; }

  // The body at height z_W in the map and z_O for DR, after so many resets.
  KeyframeId Go(double z_W, std::optional<double> z_O, uint32_t resets = 0, KeyframeId piece = {}) {
    Keyframe k;
    k.id = {map_.newest_keyframe().value + 1};
    k.utime = Utime{1'000'000 * k.id.value};
    k.T_WC = SE3(Eigen::Quaterniond::Identity(), {1.0 * static_cast<double>(k.id.value), 0, z_W}) *
             kCamera;
    k.piece = piece;
    if (k.id.value > 1 && k.id != piece) k.previous = {k.id.value - 1};
    if (z_O) k.height = DrHeight{*z_O, 4e-4, resets};
    EXPECT_TRUE(map_.AddKeyframe(k));
    return k.id;
  }

 private:
  Map map_;
};

TEST(FloorLevels, ARunKeepsTheLevelAtWhichItBegan) {
  Drive drive;
  for (int i = 0; i < 5; ++i) drive.Go(i == 2 ? 0.4 : 0.001 * i, 1.0);  // one that is off
  const KeyframeId drifted = drive.Go(0.06, 1.02);
  for (int i = 0; i < 20; ++i) drive.Go(0.3, 1.0);
  const auto height = FloorLevels(drive.map(), kCamera).Of(drifted);
  ASSERT_TRUE(height);
  EXPECT_NEAR(height->z_W, 0.02, 0.005);
  EXPECT_NEAR(height->sigma, 0.02, 1e-12);
}

TEST(FloorLevels, ARunEndsWhereDrBeginsAnew) {
  Drive drive;
  for (int i = 0; i < 5; ++i) drive.Go(0, 0);
  const KeyframeId other = drive.Go(0.7, 0.1, /*resets=*/1);
  const KeyframeId after = drive.Go(0.75, 0.12, 1);
  const FloorLevels levels(drive.map(), kCamera);
  EXPECT_NEAR(levels.Of(other)->z_W, 0.73, 1e-9);  // the median of two is the larger
  EXPECT_NEAR(levels.Of(after)->z_W, 0.75, 1e-9);
}

TEST(FloorLevels, APieceHasALevelOfItsOwn) {
  Drive drive;
  for (int i = 0; i < 5; ++i) drive.Go(0, 0);
  const KeyframeId first{drive.map().newest_keyframe().value + 1};
  drive.Go(2, 0, 0, first);
  const KeyframeId of_piece = drive.Go(2, 0.01, 0, first);
  EXPECT_NEAR(FloorLevels(drive.map(), kCamera).Of(of_piece)->z_W, 2.01, 0.011);
}

TEST(FloorLevels, AnotherFloorHasItsOwn) {
  Drive drive;
  for (int i = 0; i < 5; ++i) drive.Go(0, 0);
  const KeyframeId held = drive.Go(0.065, 0);  // sigma is 0.02
  const KeyframeId after = drive.Go(0.067, 0);
  for (int i = 0; i < 4; ++i) drive.Go(0.08, 0);
  const KeyframeId later = drive.Go(0.1, 0);
  const FloorLevels levels(drive.map(), kCamera);
  EXPECT_NEAR(levels.Of(held)->z_W, 0, 1e-12);
  EXPECT_NEAR(levels.Of(after)->z_W, 0.08, 1e-12);
  EXPECT_NEAR(levels.Of(later)->z_W, 0.08, 1e-12);
}

TEST(FloorLevels, WithoutAHeightNothingIsHeld) {
  Drive drive;
  const KeyframeId first = drive.Go(0, 0);
  const KeyframeId none = drive.Go(0, std::nullopt);
  const KeyframeId after = drive.Go(0.5, 0.0);
  const FloorLevels levels(drive.map(), kCamera);
  EXPECT_TRUE(levels.Of(first));
  EXPECT_FALSE(levels.Of(none));
  EXPECT_NEAR(levels.Of(after)->z_W, 0.5, 1e-9);  // what lies between may be a lift
}

}  // namespace
}  // namespace gw::backend

#include "tools/data/foxglove/map_view.h"

#include <gtest/gtest.h>

namespace gw::foxglove {
namespace {

SE3 At(double x) {
  return {Eigen::Quaterniond::Identity(), {x, 0, 0}};
}

MapUpdate Snapshot() {
  MapUpdate update;
  update.snapshot = true;
  update.revision = 5;
  update.keyframes = {{{1}, {0}, At(1)}, {{2}, {0}, At(2)}};
  update.landmarks.push_back({.id = LandmarkId::From({1}, 3), .observations = {{{1}, 3}}});
  return update;
}

TEST(MapView, ASnapshotIsTheWholeMapAndAGapIsNot) {
  MapView map;
  EXPECT_FALSE(map.complete());
  map.Take(Snapshot());
  EXPECT_TRUE(map.complete());
  EXPECT_EQ(map.keyframes().size(), 2u);
  EXPECT_EQ(map.landmarks().size(), 1u);
  MapUpdate later;
  later.base_revision = 7;
  later.revision = 8;
  map.Take(later);
  EXPECT_FALSE(map.complete());
}

TEST(MapView, KeyframesThatLeftAreFoundThroughTheirParents) {
  MapView map;
  map.Take(Snapshot());
  MapUpdate update;
  update.base_revision = 5;
  update.revision = 6;
  update.removed_keyframes = {{{2}, {1}, At(1)}};
  map.Take(update);
  EXPECT_FALSE(map.KeyframePose({2}));
  ASSERT_TRUE(map.PoseNow({2}));
  EXPECT_NEAR(map.PoseNow({2})->translation().x(), 2, 1e-12);
}

TEST(MapView, ACircleOfRemovalsEnds) {
  MapView map;
  map.Take(Snapshot());
  MapUpdate update;
  update.base_revision = 5;
  update.revision = 6;
  update.removed_keyframes = {{{1}, {2}, At(1)}, {{2}, {1}, At(1)}};
  map.Take(update);
  EXPECT_FALSE(map.PoseNow({1}));
}

TEST(MapView, WhatIsSentAgainChangesNothing) {
  MapView map;
  map.Take(Snapshot());
  MapUpdate loop;
  loop.base_revision = 5;
  loop.revision = 6;
  loop.loops = {{{2}, {1}, true, At(0.1)}, {{2}, {1}, false, At(9)}};
  map.Take(loop);
  map.Take(loop);
  EXPECT_EQ(map.loops().size(), 1u);
}

}  // namespace
}  // namespace gw::foxglove

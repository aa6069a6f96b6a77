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

TEST(MapView, IsCompleteFromTheFirstUpdateOfANewMap) {
  MapView map;
  MapUpdate first;
  first.revision = 1;
  map.Take(first);
  EXPECT_TRUE(map.complete());
  MapView late;
  first.base_revision = 3;
  first.revision = 4;
  late.Take(first);
  EXPECT_FALSE(late.complete());
}

TEST(MapView, CountsPiecesUntilTheyAreJoined) {
  MapView map;
  MapUpdate update = Snapshot();
  update.keyframes.push_back({{3}, {0}, At(3), {3}});
  update.keyframes.push_back({{4}, {0}, At(4), {3}});
  map.Take(update);
  EXPECT_EQ(map.num_pieces(), 1u);
  EXPECT_TRUE(map.InPiece({4}));
  EXPECT_FALSE(map.InPiece({1}));
  MapUpdate join;
  join.base_revision = 5;
  join.revision = 6;
  join.keyframes = {{{3}, {0}, At(3), {}}, {{4}, {0}, At(4), {}}};
  map.Take(join);
  EXPECT_EQ(map.num_pieces(), 0u);
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

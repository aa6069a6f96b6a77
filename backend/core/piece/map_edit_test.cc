#include "backend/core/piece/map_edit.h"

#include <gtest/gtest.h>

#include "backend/core/map/map_check.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

Map Driven(int keyframes) {
  return DrivenMap({.num_points = 600, .keyframes_per_lap = 40}, keyframes);
}

TEST(MapEdit, WhatIsKeptHoldsTogetherAndWhatGoesLeavesNothing) {
  const Map map = Driven(12);
  const Map kept = KeepKeyframes(map, [](const MapKeyframe& keyframe) {
    return keyframe.frame.id.value < 5 || keyframe.frame.id.value > 8;
  });
  const MapFaults faults = CheckMap(kept);
  EXPECT_EQ(faults.count, 0) << faults.texts[0];
  EXPECT_EQ(kept.keyframes().size(), map.keyframes().size() - 4);
  EXPECT_FALSE(kept.FindRemoval({6}));
  EXPECT_EQ(kept.newest_keyframe(), map.newest_keyframe());  // ids are not given out again
  for (const LandmarkId id : kept.SortedLandmarkIds()) {
    EXPECT_EQ(kept.FindLandmark(id)->p_W, map.FindLandmark(id)->p_W);
    EXPECT_FALSE(kept.FindLandmark(id)->observations.empty());
  }
  EXPECT_LT(kept.num_landmarks(), map.num_landmarks());
  // Dead reckoning leads on over the gap.
  const Keyframe& after = kept.FindKeyframe({9})->frame;
  EXPECT_EQ(after.previous, KeyframeId{4});
  ASSERT_TRUE(after.dr);
  EXPECT_EQ(after.dr->utime_begin, kept.FindKeyframe({4})->frame.utime);
}

TEST(MapEdit, NothingKeptIsAnEmptyMap) {
  EXPECT_TRUE(KeepKeyframes(Driven(3), [](const auto&) { return false; }).keyframes().empty());
}

TEST(MapEdit, TwoMapsInOneAreTwoPieces) {
  const Map a = Driven(5);
  const Map b = Driven(7);
  const Map both = PutTogether(a, b);
  const MapFaults faults = CheckMap(both);
  EXPECT_EQ(faults.count, 0) << faults.texts[0];
  EXPECT_EQ(both.keyframes().size(), 12u);
  EXPECT_EQ(both.num_landmarks(), a.num_landmarks() + b.num_landmarks());
  EXPECT_EQ(both.FirstOfPieces(), (std::map<KeyframeId, KeyframeId>{{{}, {1}}, {{6}, {6}}}));
  for (int k = 1; k <= 7; ++k) {
    const MapKeyframe& of_b = *both.FindKeyframe({5 + k});
    EXPECT_EQ(of_b.frame.T_WC.translation(), b.FindKeyframe({k})->frame.T_WC.translation());
    EXPECT_EQ(of_b.num_observations, b.FindKeyframe({k})->num_observations);
    EXPECT_EQ(of_b.frame.piece, KeyframeId{6});
  }
  EXPECT_EQ(both.FindKeyframe({12})->frame.previous, KeyframeId{11});
}

TEST(MapEdit, AJoinedPieceMovesAsAWhole) {
  const Map b = Driven(6);
  Map both = PutTogether(Driven(4), b);
  const SE3 T_AB(ExpSO3({0, 0, 1}), {3, -2, 0});
  both.JoinPiece({5}, {}, T_AB);
  const MapUpdate update = both.Commit();
  EXPECT_EQ(CheckMap(both).count, 0);
  EXPECT_EQ(both.FirstOfPieces(), (std::map<KeyframeId, KeyframeId>{{{}, {1}}}));
  EXPECT_EQ(update.keyframes.size(), 6u);
  EXPECT_EQ(update.landmarks.size(), b.num_landmarks());
  const LandmarkId of_b = b.SortedLandmarkIds().front();
  const LandmarkId now = LandmarkId::From({of_b.creator().value + 4}, of_b.feature_index());
  EXPECT_LT((both.FindLandmark(now)->p_W - T_AB * b.FindLandmark(of_b)->p_W).norm(), 1e-12);
  // Whoever follows by updates has the same map.
  Map replica = PutTogether(Driven(4), b);
  EXPECT_NE(replica.Hash(), both.Hash());
  ASSERT_EQ(replica.Apply(update), Map::Applied::kDone);
  EXPECT_EQ(replica.Hash(), both.Hash());
}

}  // namespace
}  // namespace gw::backend

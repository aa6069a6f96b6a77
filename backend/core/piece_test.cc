// Pieces of a map that show the same place are joined, live and when two maps are merged.
#include <gtest/gtest.h>

#include "backend/core/map/map_check.h"
#include "backend/core/mapper.h"
#include "backend/core/merge_maps.h"
#include "backend/core/piece/piece_join.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

constexpr int kLap = 40;

// Where the second session believes its origin to be.
const SE3 kElsewhere(ExpSO3({0, 0, 0.8}), {5, -3, 0});

// Keyframes [from, to) in a frame of their own, as a piece of the map; those of the map itself name
// no piece.
void Drive(World& world, int from, int to, const SE3& T_FrameW, KeyframeId piece, Mapper* mapper) {
  for (int k = from; k < to; ++k) {
    Keyframe keyframe = world.Make(k, mapper->map());
    keyframe.T_WC = T_FrameW * keyframe.T_WC;
    keyframe.piece = piece;
    if (k == from) {
      keyframe.previous = {};
      keyframe.dr.reset();
    }
    ASSERT_EQ(mapper->Insert(keyframe).status, InsertResult::Status::kInserted);
  }
}

Mapper NewMapper() {
  return *Mapper::Create(BackendConfig{}, FrontendConfig{}, TestCamera());
}

double Error(const World& world, const Map& map, KeyframeId id) {
  const SE3 truth = world.TruePose(static_cast<int>(id.value) - 1);
  return (truth.inverse() * map.FindKeyframe(id)->frame.T_WC).Log().norm();
}

TEST(PieceJoin, APieceThatComesToMappedGroundIsJoined) {
  World world = SettledWorld(1.5);
  World beside = SettledWorld(1.2);
  Mapper mapper = NewMapper();
  Drive(world, 0, kLap / 2, SE3(), {}, &mapper);
  Drive(beside, kLap / 2, kLap / 2 + 3, kElsewhere, {kLap / 2 + 1}, &mapper);
  // Half a lap on the map has seen nothing of what is here: the pieces stay apart.
  const KeyframeId first{kLap / 2 + 1};
  EXPECT_EQ(mapper.counters().pieces_joined, 0);
  EXPECT_EQ(mapper.map().FirstOfPieces().size(), 2u);
  EXPECT_EQ(CheckMap(mapper.map()).count, 0);
  int k = kLap / 2 + 3;
  std::optional<MapUpdate> joined;
  for (; k < 2 * kLap && !joined; ++k) {
    Keyframe keyframe = beside.Make(k, mapper.map());
    keyframe.T_WC = kElsewhere * keyframe.T_WC;
    keyframe.piece = first;
    const InsertResult result = mapper.Insert(keyframe);
    ASSERT_TRUE(result.update);
    if (!result.update->loops.empty()) joined = result.update;
  }
  ASSERT_TRUE(joined);
  EXPECT_LT(k, kLap + 6);  // where the first lap began, or looks at it from before
  EXPECT_EQ(mapper.counters().pieces_joined, 1);
  EXPECT_FALSE(mapper.map().IsInPieces());
  EXPECT_EQ(CheckMap(mapper.map()).count, 0);
  EXPECT_LT(Error(beside, mapper.map(), first), 0.15);
  EXPECT_LT(Error(beside, mapper.map(), {k}), 0.1);
  EXPECT_TRUE(mapper.GlobalBaDue());
  // A keyframe that was tracked in the piece, before the front-end heard of it, comes to lie right.
  Keyframe late = beside.Make(k, mapper.map());
  late.T_WC = kElsewhere * beside.TruePose(k);
  late.piece = first;
  late.map_revision = joined->base_revision;
  ASSERT_TRUE(mapper.Insert(late).update);
  EXPECT_EQ(mapper.map().PieceOf(late.id), KeyframeId{});
  EXPECT_LT(Error(beside, mapper.map(), late.id), 0.1);
  EXPECT_EQ(CheckMap(mapper.map()).count, 0);
}

// A person stood in front of the camera while a piece was mapped: what was mapped then is taken out
// by the keyframe after it, which is looked for in the other pieces at once.
TEST(PieceJoin, WhatIsWithdrawnIsNoPlace) {
  World world = SettledWorld(1.5);
  World beside = SettledWorld(1.2);
  Mapper mapper = NewMapper();
  Drive(world, 0, kLap / 2, SE3(), {}, &mapper);
  const KeyframeId first{kLap / 2 + 1};
  Drive(beside, kLap / 2, kLap / 2 + 4, kElsewhere, first, &mapper);
  Keyframe after = beside.Make(kLap / 2 + 4, mapper.map());
  after.T_WC = kElsewhere * after.T_WC;
  after.piece = first;
  after.previous = first;
  after.dr.reset();
  after.withdraws = true;
  const InsertResult result = mapper.Insert(after);
  ASSERT_TRUE(result.update);
  EXPECT_EQ(result.update->removed_keyframes.size(), 3u);
  EXPECT_EQ(CheckMap(mapper.map()).count, 0);
}

TEST(PieceJoin, AnotherRoomStaysAPieceOfItsOwn) {
  World world = SettledWorld(1.5);
  World other = SettledWorld(1.5, 2);
  Mapper mapper = NewMapper();
  Drive(world, 0, kLap, SE3(), {}, &mapper);
  Drive(other, kLap, 2 * kLap, kElsewhere, {kLap + 1}, &mapper);
  EXPECT_EQ(mapper.counters().pieces_joined, 0);
  EXPECT_EQ(mapper.map().FirstOfPieces().size(), 2u);
  const auto faults = CheckMap(mapper.map());
  EXPECT_EQ(faults.count, 0) << faults.texts[0];
  // The whole map can be optimised: each piece holds itself.
  const SE3 before = mapper.map().FindKeyframe({kLap + 1})->frame.T_WC;
  const auto result = SolveLocalBa(*mapper.BuildGlobalJob());
  ASSERT_TRUE(result.usable);
  ASSERT_TRUE(mapper.ApplyGlobal(result));
  EXPECT_EQ(mapper.map().FindKeyframe({kLap + 1})->frame.T_WC.translation(), before.translation());
}

Map MapOf(World& world, const SE3& T_FrameW) {
  Mapper mapper = NewMapper();
  Drive(world, 0, kLap, T_FrameW, {}, &mapper);
  return mapper.map();
}

TEST(MergeMaps, TwoSessionsInOneRoomBecomeOneMap) {
  World world = SettledWorld(1.5);
  World beside = SettledWorld(1.2);
  const Map a = MapOf(world, SE3());
  const Map b = MapOf(beside, kElsewhere);
  const auto merged = MergeMaps(a, b, {}, {}, TestCamera());
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ(CheckMap(merged->map).count, 0);
  EXPECT_GT(merged->views, kLap / 4);
  EXPECT_EQ(merged->map.FirstOfPieces().size(), 1u);
  // Both see the same landmarks now.
  EXPECT_LT(merged->map.num_landmarks(), a.num_landmarks() + b.num_landmarks());
  for (const auto& [id, keyframe] : merged->map.keyframes()) {
    const bool of_a = id <= a.newest_keyframe();
    const SE3 truth = of_a ? world.TruePose(static_cast<int>(id.value) - 1)
                           : beside.TruePose(static_cast<int>(id.value) - 1 - kLap);
    EXPECT_LT((truth.inverse() * keyframe.frame.T_WC).Log().norm(), 0.1) << id.value;
  }
}

TEST(MergeMaps, MapsOfTwoRoomsAreNotMerged) {
  World world = SettledWorld(1.5);
  World other = SettledWorld(1.5, 2);
  const auto merged = MergeMaps(MapOf(world, SE3()), MapOf(other, SE3()), {}, {}, TestCamera());
  ASSERT_FALSE(merged.ok());
  EXPECT_EQ(merged.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace gw::backend

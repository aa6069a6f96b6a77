#include "tools/data/foxglove/line_scene.h"

#include <gtest/gtest.h>

#include "tools/data/files/json.h"

namespace gw::foxglove {
namespace {

constexpr Color kBlue{0, 0, 1, 1}, kRed{1, 0, 0, 1};

size_t PointsOf(const Json& entity) {
  return entity["lines"][0]["points"].size();
}

TEST(LineScene, StandingStillAddsNothing) {
  LineScene line({"way"});
  for (int i = 0; i < 100; ++i) line.Add({0.0001 * i, 0, 0}, kBlue, {});
  EXPECT_EQ(line.size(), 1u);
  line.Add({0, 0, 0}, kRed, {});
  EXPECT_EQ(line.size(), 2u);
}

TEST(LineScene, OnlyTheLastPieceIsSentAgain) {
  LineScene line({"way"});
  for (size_t i = 0; i < LineScene::kPiece + 50; ++i) {
    line.Add({0.1 * static_cast<double>(i), 0, 0}, kBlue, {});
  }
  EXPECT_EQ(line.TakeChanged({}).size(), 2u);
  line.Add({1000, 0, 0}, kBlue, {});
  const Json changed = line.TakeChanged({});
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_EQ(changed[0]["id"], "way/1");
  EXPECT_EQ(PointsOf(changed[0]), 52u);  // and the last of the piece before, so that they touch
  EXPECT_EQ(line.All({}).size(), 2u);
}

TEST(LineScene, ABreakIsNotDrawn) {
  LineScene line({"way"});
  line.Add({0, 0, 0}, kBlue, {});
  line.Break();
  line.Add({5, 0, 0}, kBlue, {});
  const Json all = line.All({});
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(PointsOf(all[1]), 1u);
}

TEST(LineScene, PointsFollowTheirKeyframe) {
  MapView map;
  MapUpdate update;
  update.snapshot = true;
  update.revision = 1;
  update.keyframes = {{{1}, {0}, SE3()}};
  map.Take(update);
  LineScene line({"way"});
  line.Add({1, 0, 0}, kBlue, LineScene::Anchor{{1}, {1, 0, 0}});
  line.TakeChanged({});
  update.snapshot = false;
  update.base_revision = 1;
  update.revision = 2;
  update.keyframes[0].T_WC = SE3(Eigen::Quaterniond::Identity(), {0, 3, 0});
  map.Take(update);
  line.Follow(map);
  const Json moved = line.TakeChanged({});
  ASSERT_EQ(moved.size(), 1u);
  EXPECT_NEAR(moved[0]["lines"][0]["points"][0]["y"].get<double>(), 3, 1e-12);
}

TEST(LineScene, AKeyframeThatIsKnownOnlyLaterIsFollowedToo) {
  LineScene line({"way"});
  line.Add({1, 0, 0}, kBlue, LineScene::Anchor{{1}, {1, 0, 0}});
  MapView map;
  line.Follow(map);
  MapUpdate update;
  update.snapshot = true;
  update.revision = 1;
  update.keyframes = {{{1}, {0}, SE3(Eigen::Quaterniond::Identity(), {0, 3, 0})}};
  map.Take(update);
  line.Follow(map);
  EXPECT_NEAR(line.All({})[0]["lines"][0]["points"][0]["y"].get<double>(), 3, 1e-12);
}

TEST(LineScene, MemoryIsBounded) {
  LineScene line({"way"});
  for (size_t i = 0; i < (LineScene::kMaxPieces + 5) * LineScene::kPiece; ++i) {
    line.Add({0.1 * static_cast<double>(i), 0, 0}, kBlue, {});
  }
  EXPECT_EQ(line.All({}).size(), LineScene::kMaxPieces);
}

}  // namespace
}  // namespace gw::foxglove

// Where was an image taken? Asked of the map of one lap through a small world.
#include "backend/core/loop/locate.h"

#include <gtest/gtest.h>

#include "backend/core/loop/place_fit.h"
#include "backend/core/mapper.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

constexpr int kLap = 40;

class LocateTest : public testing::Test {
 protected:
  LocateTest()
      : world_(SettledWorld(1.5)),
        mapper_(*Mapper::Create(BackendConfig{}, FrontendConfig{}, TestCamera())) {
    for (int k = 0; k < kLap; ++k) {
      EXPECT_EQ(mapper_.Insert(world_.Make(k, mapper_.map())).status,
                InsertResult::Status::kInserted);
    }
  }

  PlaceQuery See(World& world, int k) {
    const Keyframe seen = world.Make(k, mapper_.map());
    return {seen.utime, 1, seen.features, seen.descriptors};
  }

  World world_;
  Mapper mapper_;
};

TEST_F(LocateTest, FindsThePlaceOfAnImage) {
  for (const int k : {kLap + 5, kLap + 18, kLap + 31}) {
    const PlaceMatch match = mapper_.Locate(See(world_, k));
    ASSERT_TRUE(match.found) << k;
    EXPECT_GE(match.num_sights, kFewestMatches);
    EXPECT_LT((match.T_WC.inverse() * world_.TruePose(k)).Log().norm(), 0.1) << k;
  }
}

TEST_F(LocateTest, FindsItFromHalfAMetreBeside) {
  World beside = SettledWorld(1.0);
  for (const int k : {kLap + 5, kLap + 18, kLap + 31}) {
    const PlaceMatch match = mapper_.Locate(See(beside, k));
    ASSERT_TRUE(match.found) << k;
    EXPECT_LT((match.T_WC.inverse() * beside.TruePose(k)).Log().norm(), 0.1) << k;
  }
}

TEST_F(LocateTest, AnotherRoomIsNotFound) {
  World other = SettledWorld(1.5, 2);
  EXPECT_FALSE(mapper_.Locate(See(other, kLap + 5)).found);
}

// A poster of the mapped room hangs in another one, too.
TEST_F(LocateTest, WhatIsAlikeInOnePartOfTheImageIsNoPlace) {
  World other = SettledWorld(1.5, 2);
  const int k = kLap + 5;
  const PlaceQuery here = See(world_, k);
  const PlaceQuery there = See(other, k);
  const auto on_poster = [](const Feature& f) {
    return f.u > 160 && f.u < 460 && f.v > 120 && f.v < 360;
  };
  PlaceQuery seen;
  seen.utime = here.utime;
  int poster = 0;
  for (size_t i = 0; i < here.features.size(); ++i) {
    if (!on_poster(here.features[i])) continue;
    seen.features.push_back(here.features[i]);
    seen.descriptors.push_back(here.descriptors[i]);
    ++poster;
  }
  ASSERT_GT(poster, 2 * kFewestMatches);
  for (size_t i = 0; i < there.features.size(); ++i) {
    if (on_poster(there.features[i])) continue;
    seen.features.push_back(there.features[i]);
    seen.descriptors.push_back(there.descriptors[i]);
  }
  EXPECT_FALSE(mapper_.Locate(seen).found);
}

}  // namespace
}  // namespace gw::backend

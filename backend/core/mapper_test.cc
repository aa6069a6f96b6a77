#include "backend/core/mapper.h"

#include <gtest/gtest.h>

#include "backend/test/world.h"

namespace gw::backend {
namespace {

Mapper MakeMapper(Variant variant = Variant::kFull) {
  FrontendConfig frontend;
  frontend.variant = variant;
  return Mapper::Create({}, frontend, TestCamera()).value();
}

// Drives keyframes [begin, end) through the mapper, local BA after each, and keeps `replica` up to
// date from keyframes and updates alone.
struct Drive {
  explicit Drive(const WorldOptions& options, Variant variant = Variant::kFull)
      : world(options), mapper(MakeMapper(variant)) {}

  void Step(int k, bool blind = false) {
    const Keyframe keyframe = world.Make(k, mapper.map(), blind);
    const InsertResult inserted = mapper.Insert(keyframe);
    ASSERT_EQ(inserted.status, InsertResult::Status::kInserted) << inserted.reason;
    ASSERT_TRUE(replica.AddKeyframe(keyframe));
    Follow(*inserted.update);
    if (const auto job = mapper.BuildJob()) {
      last = SolveLocalBa(*job);
      const auto update = mapper.Apply(last);
      ASSERT_TRUE(update);
      Follow(*update);
    }
  }
  void Follow(const MapUpdate& update) {
    ASSERT_EQ(replica.Apply(update), Map::Applied::kDone);
    ASSERT_EQ(replica.Hash(), mapper.map().Hash());
  }

  World world;
  Mapper mapper;
  Map replica;
  LocalBaResult last;
};

TEST(Mapper, LocalBaBringsPosesToWhatTheNoiseAllows) {
  Drive drive({.keyframes_per_lap = 160});
  for (int k = 0; k < 40; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  // Tracked poses are off by 0.017 m, and each depth by 5 to 20 %; together they have to do better.
  EXPECT_LT(PositionRmse(drive.world, drive.mapper.map()), 0.010);
  EXPECT_EQ(drive.replica.num_ignored(), 0);
}

}  // namespace
}  // namespace gw::backend

#include "backend/core/loop/loop_closer.h"

#include <gtest/gtest.h>

#include "backend/core/mapper.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

Mapper MakeMapper() {
  FrontendConfig frontend;
  return *Mapper::Create(BackendConfig{}, frontend, TestCamera());
}

// A tracker that forgets after 8 keyframes and drifts 4 cm and 1 deg per keyframe.
WorldOptions Forgetful() {
  WorldOptions options;
  options.memory_keyframes = 8;
  options.pose_sigma_m = 0.02;
  options.pose_sigma_rad = 0.008;
  options.dr_sigma_m = 0.01;
  options.dr_sigma_rad = 0.005;
  return options;
}

double ErrorAcross(const World& world, const Map& map, const Loop& loop) {
  const auto index = [](KeyframeId id) { return static_cast<int>(id.value) - 1; };
  const SE3 truth = world.TruePose(index(loop.older)).inverse() * world.TruePose(index(loop.newer));
  const SE3 mapped =
      map.FindKeyframe(loop.older)->frame.T_WC.inverse() * map.FindKeyframe(loop.newer)->frame.T_WC;
  return (truth.inverse() * mapped).translation().norm();
}

struct Drive {
  Mapper mapper = MakeMapper();
  std::vector<LoopGraphJob> jobs;
  std::vector<MapUpdate> loop_updates;
  // Around the first closure: RMSE, and the error of the relative pose across the loop (m).
  double before = 0, after = 0;
  double across_before = 0, across_after = 0;

  // Keyframes [from, to) of the world, with loops closed as they are found.
  void Run(World& world, int from, int to, bool local_ba = false) {
    for (int k = from; k < to; ++k) {
      ASSERT_EQ(mapper.Insert(world.Make(k, mapper.map())).status, InsertResult::Status::kInserted);
      if (local_ba && k % 2 == 0) {
        if (const auto job = mapper.BuildJob()) mapper.Apply(SolveLocalBa(*job));
      }
      const auto job = mapper.CloseLoop();
      if (!job) continue;
      jobs.push_back(*job);
      const double rmse = PositionRmse(world, mapper.map());
      const double across = ErrorAcross(world, mapper.map(), job->loops.back());
      auto update = mapper.Apply(SolveLoopGraph(*job));
      if (!update) continue;
      if (loop_updates.empty()) {
        before = rmse;
        after = PositionRmse(world, mapper.map());
        across_before = across;
        across_after = ErrorAcross(world, mapper.map(), job->loops.back());
      }
      loop_updates.push_back(*update);
    }
  }
};

TEST(LoopCloser, TheSecondLapFindsTheFirstAndTheDriftGoes) {
  // One lap has more of a drift than another: what the loops take off is judged over five.
  double before = 0, after = 0, across_before = 0, across_after = 0;
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    WorldOptions options = Forgetful();
    options.seed = seed;
    World world(options);
    Drive drive;
    drive.Run(world, 0, 46);
    ASSERT_FALSE(drive.loop_updates.empty()) << seed;
    const LoopEvent& loop = drive.loop_updates[0].loops.at(0);
    EXPECT_TRUE(loop.accepted) << seed;
    EXPECT_GE(loop.from.value, 35) << seed;  // of 40 in a lap: it looks ahead
    EXPECT_LE(loop.to.value, 10) << seed;
    // Both laps now observe the same landmarks.
    EXPECT_GT(drive.mapper.map().SharedLandmarks(loop.from, loop.to), 30) << seed;
    EXPECT_EQ(drive.mapper.loop_counters().closed, std::ssize(drive.loop_updates)) << seed;
    EXPECT_EQ(drive.mapper.loop_counters().removed, 0) << seed;
    before += drive.before;
    after += drive.after;
    across_before += drive.across_before;
    across_after += drive.across_after;
  }
  EXPECT_LT(across_after, 0.3 * across_before) << across_before << " -> " << across_after;
  EXPECT_LT(after, 0.7 * before) << before << " -> " << after;
}

TEST(LoopCloser, AReplicaFollowsTheCorrection) {
  World world(Forgetful());
  Mapper mapper = MakeMapper();
  Map replica;
  const auto follow = [&](const MapUpdate& update) {
    ASSERT_EQ(replica.Apply(update), Map::Applied::kDone);
  };
  bool closed = false;
  for (int k = 0; k < 46; ++k) {
    const Keyframe keyframe = world.Make(k, mapper.map());
    const InsertResult inserted = mapper.Insert(keyframe);
    replica.AddKeyframe([&] {
      Keyframe as_taken = keyframe;
      as_taken.T_WC = mapper.map().FindKeyframe(keyframe.id)->frame.T_WC;
      return as_taken;
    }());
    follow(*inserted.update);
    if (const auto job = mapper.CloseLoop()) {
      if (const auto update = mapper.Apply(SolveLoopGraph(*job))) {
        follow(*update);
        closed = true;
      }
    }
  }
  EXPECT_TRUE(closed);
  EXPECT_EQ(replica.Hash(), mapper.map().Hash());
}

TEST(LoopCloser, KeyframesBornWhileTheGraphIsSolvedFollow) {
  World world(Forgetful());
  Mapper mapper = MakeMapper();
  int k = 0;
  std::optional<LoopGraphJob> job;
  for (; k < 60 && !job; ++k) {
    mapper.Insert(world.Make(k, mapper.map()));
    job = mapper.CloseLoop();
  }
  ASSERT_TRUE(job);
  const KeyframeId last = job->newest;
  mapper.Insert(world.Make(k, mapper.map()));
  const KeyframeId born = mapper.map().newest_keyframe();
  ASSERT_GT(born, last);
  const auto relative = [&] {
    return mapper.map().FindKeyframe(last)->frame.T_WC.inverse() *
           mapper.map().FindKeyframe(born)->frame.T_WC;
  };
  const SE3 before = relative();
  ASSERT_TRUE(mapper.Apply(SolveLoopGraph(*job)));
  EXPECT_LT((before.inverse() * relative()).Log().norm(), 1e-9);
}

TEST(LoopCloser, DeadReckoningRefusesALoopBeyondItsDrift) {
  World world(Forgetful());
  Mapper mapper = MakeMapper();
  for (int k = 0; k < 30; ++k) mapper.Insert(world.Make(k, mapper.map()));
  const MappingContext context = MappingContext({}, {}, TestCamera());
  const auto chain = ChainDr(mapper.map(), context, {2}, {28});
  ASSERT_TRUE(chain);
  const SE3 truth = world.TruePose(1).inverse() * world.TruePose(27);
  const Matrix6d cov_loop = Matrix6d::Identity() * 1e-4;
  EXPECT_LT(DrContradiction(*chain, truth, cov_loop), kDrGate);
  const SE3 elsewhere = truth * SE3(Eigen::Quaterniond::Identity(), {4, 0, 0});
  EXPECT_GT(DrContradiction(*chain, elsewhere, cov_loop), kDrGate);
  EXPECT_FALSE(ChainDr(mapper.map(), context, {28}, {2}));  // backwards there is no chain
}

TEST(LoopCloser, ALoopFoundWrongLaterIsTakenBack) {
  WorldOptions options = Forgetful();
  options.pose_sigma_m = 0.01;
  options.pose_sigma_rad = 0.004;
  World world(options);
  Drive drive;
  drive.Run(world, 0, 25);
  ASSERT_TRUE(drive.jobs.empty());
  // A wrong loop between two far places, closed by force.
  const MappingContext context = MappingContext({}, {}, TestCamera());
  Map map = drive.mapper.map();
  LoopCloser closer(map);
  Loop wrong;
  wrong.older = {3};
  wrong.newer = {22};
  wrong.T_OlderNewer = SE3();
  wrong.sqrt_information = 100 * Matrix6d::Identity();
  LoopGraphResult forced;
  forced.newest = map.newest_keyframe();
  forced.loops = {wrong};
  forced.graph.usable = true;
  forced.graph.group_kept = {1};
  closer.Settle(map, context, forced);
  EXPECT_EQ(closer.counters().closed, 1);
  // A landmark that both sides were made to share.
  const auto& newer = map.FindKeyframe({22})->frame.landmarks;
  const LandmarkId shared = *std::find_if(map.FindKeyframe({3})->frame.landmarks.begin(),
                                          map.FindKeyframe({3})->frame.landmarks.end(),
                                          [](LandmarkId id) { return id.valid(); });
  const auto free =
      std::find_if(newer.begin(), newer.end(), [](LandmarkId id) { return !id.valid(); });
  ASSERT_NE(free, newer.end());
  ASSERT_TRUE(map.AddObservation(shared, {{22}, static_cast<int32_t>(free - newer.begin())}));

  // The next loop is true, and the graph cannot have both.
  Loop right;
  right.older = {2};
  right.newer = {21};
  right.T_OlderNewer = world.TruePose(1).inverse() * world.TruePose(20);
  right.sqrt_information = 100 * Matrix6d::Identity();
  const LoopGraphResult result = SolveLoopGraph(closer.CutGraph(map, context, right));
  ASSERT_TRUE(result.graph.usable);
  EXPECT_TRUE(result.closed());
  EXPECT_EQ(result.graph.group_kept.front(), 0);
  closer.Settle(map, context, result);
  EXPECT_EQ(closer.counters().removed, 1);
  EXPECT_EQ(map.SharedLandmarks({3}, {22}), 0);
}

TEST(LoopCloser, GlobalBaImprovesTheClosedMap) {
  World world(Forgetful());
  Drive drive;
  drive.Run(world, 0, 44, true);
  ASSERT_FALSE(drive.loop_updates.empty());
  const auto job = drive.mapper.BuildGlobalJob();
  ASSERT_TRUE(job);
  EXPECT_EQ(job->keyframes.size(), drive.mapper.map().keyframes().size());
  EXPECT_FALSE(job->dr_edges.empty());
  // A keyframe is born while it runs.
  drive.mapper.Insert(world.Make(44, drive.mapper.map()));
  const LocalBaResult result = SolveLocalBa(*job);
  const double before = PositionRmse(world, drive.mapper.map());
  ASSERT_TRUE(drive.mapper.ApplyGlobal(result));
  EXPECT_LT(PositionRmse(world, drive.mapper.map()), 0.8 * before) << before;
}

TEST(LoopCloser, GlobalBaCutBeforeALoopIsRefused) {
  World world(Forgetful());
  Drive drive;
  drive.Run(world, 0, 20);
  const LocalBaResult early = SolveLocalBa(*drive.mapper.BuildGlobalJob());
  ASSERT_TRUE(early.usable);
  drive.Run(world, 20, 46);
  ASSERT_FALSE(drive.loop_updates.empty());
  const uint64_t hash = drive.mapper.map().Hash();
  EXPECT_FALSE(drive.mapper.ApplyGlobal(early));
  EXPECT_EQ(drive.mapper.counters().global_ba_stale, 1);
  EXPECT_EQ(drive.mapper.map().Hash(), hash);
}

TEST(LoopCloser, GlobalBaIsAbandonedWhenAsked) {
  World world(Forgetful());
  Drive drive;
  drive.Run(world, 0, 20);
  const LocalBaResult result = SolveLocalBa(*drive.mapper.BuildGlobalJob(), [] { return true; });
  EXPECT_FALSE(result.usable);
  EXPECT_FALSE(drive.mapper.ApplyGlobal(result));
}

TEST(LoopCloser, GlobalBaIsDueOnKnownGroundUntilItRuns) {
  WorldOptions options;
  options.keyframes_per_lap = 100;  // 50 s
  World world(options);
  Drive drive;
  drive.Run(world, 0, 60);
  EXPECT_FALSE(drive.mapper.GlobalBaDue());  // enough is new, but the chain is open
  drive.Run(world, 60, 110);
  EXPECT_TRUE(drive.mapper.GlobalBaDue());
  ASSERT_TRUE(drive.mapper.BuildGlobalJob());
  EXPECT_FALSE(drive.mapper.GlobalBaDue());
  drive.Run(world, 110, 149);
  EXPECT_FALSE(drive.mapper.GlobalBaDue());
  const auto restarted = Mapper::Create({}, {}, TestCamera(), drive.mapper.map());
  ASSERT_TRUE(restarted);
  EXPECT_TRUE(restarted->GlobalBaDue());  // the job may have died with the process
  drive.Run(world, 149, 151);
  EXPECT_TRUE(drive.mapper.GlobalBaDue());
}

TEST(LoopCloser, VariantLbaHasNoDrEdgesInGlobalBa) {
  World world(Forgetful());
  FrontendConfig frontend;
  frontend.variant = Variant::kLba;
  Mapper mapper = *Mapper::Create(BackendConfig{}, frontend, TestCamera());
  for (int k = 0; k < 5; ++k) mapper.Insert(world.Make(k, mapper.map()));
  EXPECT_TRUE(mapper.BuildGlobalJob()->dr_edges.empty());
}

}  // namespace
}  // namespace gw::backend

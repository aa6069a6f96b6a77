#include "backend/core/mapper.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>

#include "backend/test/world.h"
#include "common/good_weights/camera_motion.h"

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

TEST(Mapper, SameCallsGiveTheSameMap) {
  Drive a({.num_points = 1500, .outlier_share = 0.03, .association_share = 0.8});
  Drive b({.num_points = 1500, .outlier_share = 0.03, .association_share = 0.8});
  for (int k = 0; k < 25; ++k) {
    ASSERT_NO_FATAL_FAILURE(a.Step(k));
    ASSERT_NO_FATAL_FAILURE(b.Step(k));
    ASSERT_EQ(a.mapper.map().Hash(), b.mapper.map().Hash());
  }
}

// Landmarks per point of the world that is in the map at all.
double LandmarksPerPoint(const World& world, const Map& map) {
  std::set<int> points;
  for (const LandmarkId id : map.SortedLandmarkIds()) {
    const Observation& o = map.FindLandmark(id)->observations.front();
    points.insert(world.PointOf(o.keyframe, o.feature_index));
  }
  return static_cast<double>(map.num_landmarks()) / static_cast<double>(points.size());
}

TEST(Mapper, FusesPointsThatTrackingCreatedTwice) {
  Drive drive(
      {.num_points = 1500, .pixel_sigma = 0.5, .association_share = 0.6, .keyframes_per_lap = 160});
  for (int k = 0; k < 20; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  EXPECT_GT(drive.mapper.counters().landmarks_merged, 100);
  EXPECT_LT(LandmarksPerPoint(drive.world, drive.mapper.map()), 1.2);
}

// Each landmark's observations show one point of the world.
TEST(Mapper, DoesNotMixPoints) {
  Drive drive({.num_points = 1500,
               .pixel_sigma = 0.5,
               .depth_share = 0.5,
               .outlier_share = 0.05,
               .association_share = 0.8,
               .keyframes_per_lap = 120});
  for (int k = 0; k < 25; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const Map& map = drive.mapper.map();
  int right = 0;
  int wrong = 0;
  for (const LandmarkId id : map.SortedLandmarkIds()) {
    std::map<int, int> votes;
    for (const Observation& o : map.FindLandmark(id)->observations) {
      ++votes[drive.world.PointOf(o.keyframe, o.feature_index)];
    }
    int most = 0;
    int all = 0;
    for (const auto& [point, n] : votes) {
      most = std::max(most, n);
      all += n;
    }
    right += most;
    wrong += all - most;
  }
  EXPECT_LT(wrong, 0.003 * right) << right;
}

TEST(Mapper, TriangulatesFeaturesWithoutDepth) {
  Drive drive({.num_points = 2000, .pixel_sigma = 0.5, .depth_share = 0.4});
  for (int k = 0; k < 12; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const Map& map = drive.mapper.map();
  int without_depth = 0;
  double error = 0;
  for (const LandmarkId id : map.SortedLandmarkIds()) {
    const Landmark& landmark = *map.FindLandmark(id);
    const MapKeyframe* creator = map.FindKeyframe(id.creator());
    if (creator == nullptr || creator->frame.features[id.feature_index()].has_depth()) continue;
    if (landmark.observations.size() < 3) continue;
    const int point = drive.world.PointOf(id.creator(), id.feature_index());
    const double distance = (drive.world.point(point) - creator->frame.T_WC.translation()).norm();
    error += (landmark.p_W - drive.world.point(point)).norm() / distance;
    ++without_depth;
  }
  ASSERT_GT(without_depth, 50);
  EXPECT_LT(error / without_depth, 0.06);
}

TEST(Mapper, DrivingTheSameWayAgainDoesNotGrowTheMap) {
  Drive drive({.num_points = 1500, .pixel_sigma = 0.2, .keyframes_per_lap = 40});
  std::vector<size_t> keyframes;
  std::vector<size_t> landmarks;
  for (int k = 0; k < 160; ++k) {
    ASSERT_NO_FATAL_FAILURE(drive.Step(k));
    if (k % 40 != 39) continue;
    keyframes.push_back(drive.mapper.map().keyframes().size());
    landmarks.push_back(drive.mapper.map().num_landmarks());
  }
  EXPECT_LT(keyframes[3], 1.05 * static_cast<double>(keyframes[1])) << keyframes[0];
  EXPECT_LT(landmarks[3], 1.05 * static_cast<double>(landmarks[1])) << landmarks[0];
  EXPECT_GT(drive.mapper.counters().keyframes_culled, 60);
}

// A span in which the camera sees nothing: only DR ties these keyframes to the rest. When the old
// landmarks come back into view the chain is corrected as a whole: no edge of it tears.
TEST(Mapper, DrHoldsTheChainTogetherAcrossABlindSpan) {
  constexpr int kFirst = 10;
  constexpr int kBlind = 8;
  Drive drive({.dr_sigma_m = 0.003, .dr_sigma_rad = 0.001, .keyframes_per_lap = 160});
  const Map& map = drive.mapper.map();
  for (int k = 0; k < kFirst; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  for (int k = kFirst; k < kFirst + kBlind; ++k) {
    ASSERT_NO_FATAL_FAILURE(drive.Step(k, /*blind=*/true));
    EXPECT_GT(map.FindKeyframe({k + 1})->dr_alpha, 900) << k;
  }
  for (int k = kFirst + kBlind; k < kFirst + kBlind + 6; ++k) {
    ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  }
  for (int k = kFirst; k <= kFirst + kBlind; ++k) {
    const MapKeyframe& keyframe = *map.FindKeyframe({k + 1});
    const SE3& T_WC = keyframe.frame.T_WC;
    EXPECT_LT((T_WC.translation() - drive.world.TruePose(k).translation()).norm(), 0.03) << k;
    const MapKeyframe& previous = *map.FindKeyframe(keyframe.frame.previous);
    const DrMotion motion = CameraMotion(*keyframe.frame.dr, TestCamera().T_BC, {});
    const SE3 T_ab = previous.frame.T_WC.inverse() * T_WC;
    EXPECT_LT((motion.T_CaCb.inverse() * T_ab).Log().norm(), 0.005) << k;
  }
}

TEST(Mapper, WithoutDrInLocalBaABlindKeyframeStaysWhereItWas) {
  Drive drive({.keyframes_per_lap = 160}, Variant::kPe);
  for (int k = 0; k < 8; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const Keyframe blind = drive.world.Make(8, drive.mapper.map(), true);
  ASSERT_NO_FATAL_FAILURE(drive.Step(8, true));
  EXPECT_EQ(drive.mapper.map().FindKeyframe({9})->frame.T_WC.matrix(), blind.T_WC.matrix());
  EXPECT_EQ(drive.mapper.map().FindKeyframe({9})->dr_alpha, 0);
}

// Local BA ran while the next keyframe was on its way: it follows its predecessor's correction.
TEST(Mapper, AKeyframeTrackedInAnOlderMapIsCarriedToTodays) {
  Drive drive({.pose_sigma_m = 0.05, .keyframes_per_lap = 160});
  for (int k = 0; k < 6; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  Mapper& mapper = drive.mapper;
  const Keyframe sixth = drive.world.Make(6, mapper.map());
  ASSERT_TRUE(mapper.Insert(sixth).update);
  Keyframe seventh = drive.world.Make(7, mapper.map());
  seventh.map_revision = sixth.map_revision;  // the front-end has heard of nothing since
  seventh.T_WC = sixth.T_WC * SE3({1, 0, 0, 0}, {0.1, 0, 0});
  ASSERT_TRUE(mapper.Apply(SolveLocalBa(*mapper.BuildJob())));
  const SE3 T_W6 = mapper.map().FindKeyframe({7})->frame.T_WC;
  ASSERT_GT((T_W6.translation() - sixth.T_WC.translation()).norm(), 0.01);
  ASSERT_TRUE(mapper.Insert(seventh).update);
  const SE3 T_67 = T_W6.inverse() * mapper.map().FindKeyframe({8})->frame.T_WC;
  EXPECT_LT((T_67.translation() - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-9);
}

// The next keyframe arrived while local BA was running: it and what it created follow.
TEST(Mapper, AResultMovesKeyframesThatArrivedMeanwhileAlong) {
  Drive drive({.pose_sigma_m = 0.05, .keyframes_per_lap = 160});
  for (int k = 0; k < 6; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  Mapper& mapper = drive.mapper;
  ASSERT_TRUE(mapper.Insert(drive.world.Make(6, mapper.map())).update);
  const LocalBaResult result = SolveLocalBa(*mapper.BuildJob());
  Keyframe seventh = drive.world.Make(7, mapper.map());
  ASSERT_TRUE(mapper.Insert(seventh).update);
  const auto relative = [&] {
    return mapper.map().FindKeyframe({7})->frame.T_WC.inverse() *
           mapper.map().FindKeyframe({8})->frame.T_WC;
  };
  const SE3 before = relative();
  const SE3 T_W7 = mapper.map().FindKeyframe({8})->frame.T_WC;
  LandmarkId own;
  for (const LandmarkId id : mapper.map().FindKeyframe({8})->frame.landmarks) {
    if (id.creator() == KeyframeId{8} && mapper.map().FindLandmark(id)->observations.size() == 1) {
      own = id;
    }
  }
  ASSERT_TRUE(own.valid());
  const Eigen::Vector3d p_C = T_W7.inverse() * mapper.map().FindLandmark(own)->p_W;
  const auto update = mapper.Apply(result);
  ASSERT_TRUE(update);
  EXPECT_LT((relative().matrix() - before.matrix()).norm(), 1e-9);
  const SE3 now = mapper.map().FindKeyframe({8})->frame.T_WC;
  EXPECT_GT((now.translation() - T_W7.translation()).norm(), 0.01);
  EXPECT_LT((now.inverse() * mapper.map().FindLandmark(own)->p_W - p_C).norm(), 1e-9);
  EXPECT_FALSE(mapper.Apply(result));  // a second time it is stale
  EXPECT_EQ(mapper.counters().local_ba_stale, 1);
}

TEST(Mapper, ObservationsOfMergedLandmarksFindTheirSuccessor) {
  Drive drive(
      {.num_points = 1500, .pixel_sigma = 0.5, .association_share = 0.6, .keyframes_per_lap = 160});
  for (int k = 0; k < 8; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const Map old = drive.mapper.map();
  for (int k = 8; k < 12; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  Keyframe late = drive.world.Make(12, drive.mapper.map());
  int merged = 0;
  for (LandmarkId& id : late.landmarks) id = {};
  for (const LandmarkId id : old.SortedLandmarkIds()) {
    const LandmarkId now = drive.mapper.map().Resolve(id);
    if (!now.valid() || now == id) continue;
    late.landmarks[static_cast<size_t>(merged++)] = id;
    if (merged == 3) break;
  }
  ASSERT_EQ(merged, 3);
  const int64_t before = drive.mapper.counters().observations_accepted;
  ASSERT_TRUE(drive.mapper.Insert(late).update);
  EXPECT_GE(drive.mapper.counters().observations_accepted, before + 1);
  EXPECT_EQ(drive.mapper.counters().observations_unknown, 0);
}

TEST(Mapper, TellsWhatItHasAgainOnRequest) {
  Drive drive({.num_points = 1000});
  for (int k = 0; k < 12; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const Map& map = drive.mapper.map();
  Map fresh;
  for (const auto& [id, keyframe] : map.keyframes()) ASSERT_TRUE(fresh.AddKeyframe(keyframe.frame));
  ASSERT_EQ(fresh.Apply(drive.mapper.Snapshot(SE3())), Map::Applied::kDone);
  EXPECT_EQ(fresh.Hash(), map.Hash());
}

TEST(Mapper, AResendIsKnownAndChangesNothing) {
  Drive drive({.num_points = 800});
  for (int k = 0; k < 3; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const uint64_t before = drive.mapper.map().Hash();
  const InsertResult again = drive.mapper.Insert(drive.world.Make(2, drive.mapper.map()));
  EXPECT_EQ(again.status, InsertResult::Status::kDuplicate);
  EXPECT_FALSE(again.update);
  EXPECT_EQ(drive.mapper.map().Hash(), before);
}

// Keyframes with anything in them: taken in or refused, never a crash, and the replica still
// agrees.
TEST(Mapper, AFrozenMapTakesNothingInAndSaysSo) {
  Drive drive({});
  for (int k = 0; k < 5; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  const uint64_t before = drive.mapper.map().Hash();
  Mapper frozen = *Mapper::Create({}, {}, TestCamera(), drive.mapper.map(), MapUse::kFrozen);
  const InsertResult result = frozen.Insert(drive.world.Make(5, frozen.map()));
  EXPECT_EQ(result.status, InsertResult::Status::kFrozen);
  EXPECT_FALSE(result.update);
  EXPECT_FALSE(frozen.BuildJob());
  EXPECT_TRUE(frozen.Snapshot(std::nullopt).frozen);
  EXPECT_FALSE(drive.mapper.Snapshot(std::nullopt).frozen);
  EXPECT_EQ(frozen.map().Hash(), before);
}

TEST(Mapper, AnotherSessionMayHaveAnEarlierClock) {
  Drive drive({});
  for (int k = 0; k < 5; ++k) ASSERT_NO_FATAL_FAILURE(drive.Step(k));
  Keyframe keyframe = drive.world.Make(5, drive.mapper.map());
  keyframe.utime = {1};
  EXPECT_EQ(drive.mapper.Insert(keyframe).status, InsertResult::Status::kRejected)
      << "time goes back along the chain";
  keyframe.previous = {};
  keyframe.dr.reset();
  EXPECT_EQ(drive.mapper.Insert(keyframe).status, InsertResult::Status::kInserted);
}

TEST(Mapper, HostileKeyframesAreRefusedOrDefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
  int refused = 0;
  int64_t inserted_in_all = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Drive drive({.seed = seed, .num_points = 400});
    for (int k = 0; k < 30; ++k) {
      Keyframe keyframe = drive.world.Make(k, drive.mapper.map());
      for (uint64_t hit = 0; hit < 1 + seed % 3; ++hit) {
        CounterRng rng(seed, static_cast<uint64_t>(k), hit);
        const size_t n = keyframe.features.size();
        const size_t i = n == 0 ? 0 : rng.Below(static_cast<uint32_t>(n));
        const auto any_landmark = [&] { return LandmarkId{static_cast<int64_t>(rng.NextU64())}; };
        switch (rng.Below(n == 0 ? 8 : 20)) {
          case 0:
            keyframe.T_WC = SE3({1, 0, 0, 0}, {kNan, 0, 0});
            break;
          case 1:
            keyframe.descriptors.resize(n / 2);
            break;
          case 2:
            keyframe.id = {-5};
            break;
          case 3:
            keyframe.previous = {static_cast<int64_t>(rng.NextU64())};
            break;
          case 4:
            keyframe.map_revision = static_cast<int64_t>(rng.NextU64());
            break;
          case 5:
            if (keyframe.dr) keyframe.dr->cov(2, 2) = rng.Below(2) == 0 ? -1 : kNan;
            break;
          case 6:
            if (keyframe.dr) keyframe.dr->T_BaBb = SE3({1, 0, 0, 0}, {0, kNan, 0});
            break;
          case 7:
            keyframe.utime = {static_cast<int64_t>(rng.Below(1000))};
            break;
          case 8:
            keyframe.features[i].u = kNanF;
            break;
          case 9:
            keyframe.features[i].v = -3e38f;
            break;
          case 10:
            keyframe.features[i].level = 255;
            break;
          case 11:
            keyframe.features[i].depth = kNanF;
            break;
          case 12:
            keyframe.features[i].depth = 1e-30f;
            break;
          case 13:
            keyframe.features[i].u_right = 1e30f;
            break;
          case 14:
            for (LandmarkId& id : keyframe.landmarks) id = any_landmark();
            break;
          case 15:
            for (LandmarkId& id : keyframe.landmarks) id = keyframe.landmarks[i];
            break;
          case 16:
            keyframe.landmarks[i] = LandmarkId::From(keyframe.id, static_cast<int>(i) + 1);
            break;
          case 17:
            keyframe.landmarks[i] = LandmarkId::From({keyframe.id.value + 7}, 0);
            break;
          case 18:
            for (Feature& f : keyframe.features) f.u = f.v = 100;
            break;
          default:
            keyframe.features[i].u_right = keyframe.features[i].u + 50;
            break;
        }
      }
      const InsertResult inserted = drive.mapper.Insert(keyframe);
      if (inserted.status != InsertResult::Status::kInserted) {
        ++refused;
        EXPECT_FALSE(inserted.update);
        continue;
      }
      ASSERT_TRUE(drive.replica.AddKeyframe(keyframe));
      ASSERT_NO_FATAL_FAILURE(drive.Follow(*inserted.update));
      if (const auto job = drive.mapper.BuildJob()) {
        if (const auto update = drive.mapper.Apply(SolveLocalBa(*job))) {
          ASSERT_NO_FATAL_FAILURE(drive.Follow(*update));
        }
      }
    }
    inserted_in_all += drive.mapper.counters().keyframes_inserted;
  }
  EXPECT_GT(refused, 40);
  EXPECT_GT(inserted_in_all, 40);
}

}  // namespace
}  // namespace gw::backend

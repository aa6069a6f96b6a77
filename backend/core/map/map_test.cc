#include "backend/core/map/map.h"

#include <gtest/gtest.h>

#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

Keyframe MakeKeyframe(int64_t id, int features = 10) {
  Keyframe out;
  out.id = {id};
  out.utime = {id * 1'000'000};
  out.previous = {id - 1};
  out.T_WC = SE3(ExpSO3({0, 0, 0.1 * static_cast<double>(id)}), {static_cast<double>(id), 0, 0});
  if (id > 1) {
    DrIncrement dr;
    dr.utime_begin = {(id - 1) * 1'000'000};
    dr.utime_end = out.utime;
    dr.T_BaBb = SE3(ExpSO3({0, 0, 0.1}), {1, 0.01 * static_cast<double>(id), 0});
    dr.cov = Matrix6d::Identity() * 1e-4 * static_cast<double>(id);
    out.dr = dr;
  }
  out.features.resize(features);
  out.descriptors.resize(features);
  out.landmarks.resize(features);
  return out;
}

// Keyframes 1..n; landmark i of keyframe k is also seen by the next two.
Map MakeMap(int n) {
  Map map;
  for (int64_t k = 1; k <= n; ++k) {
    EXPECT_TRUE(map.AddKeyframe(MakeKeyframe(k)));
    for (int i = 0; i < 3; ++i) {
      map.AddLandmark(LandmarkId::From({k}, i)).p_W = {static_cast<double>(k), 1.0 * i, 2};
    }
    for (int64_t back = 0; back < 3 && back < k; ++back) {
      for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(map.AddObservation(LandmarkId::From({k - back}, i),
                                       {{k}, static_cast<int32_t>(3 * back + i)}));
      }
    }
  }
  return map;
}

// Everything that is kept twice agrees.
void ExpectConsistent(const Map& map) {
  std::map<std::pair<KeyframeId, KeyframeId>, int> shared;
  std::map<KeyframeId, int> observed;
  for (const LandmarkId id : map.SortedLandmarkIds()) {
    const Landmark& landmark = *map.FindLandmark(id);
    for (const Observation& a : landmark.observations) {
      ++observed[a.keyframe];
      const auto& slots = map.FindKeyframe(a.keyframe)->frame.landmarks;
      ASSERT_EQ(slots.at(a.feature_index), id);
      for (const Observation& b : landmark.observations) {
        if (a.keyframe != b.keyframe) ++shared[{a.keyframe, b.keyframe}];
      }
    }
  }
  size_t pairs = 0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    EXPECT_EQ(keyframe.num_observations, observed[id]);
    pairs += keyframe.covisible.size();
    for (const auto& [other, count] : keyframe.covisible) {
      EXPECT_EQ(count, (shared[{id, other}]));
    }
    if (const MapKeyframe* next = map.FindKeyframe(keyframe.next)) {
      EXPECT_EQ(next->frame.previous, id);
    }
  }
  EXPECT_EQ(pairs, shared.size());
}

TEST(Map, CountsSharedLandmarks) {
  const Map map = MakeMap(6);
  EXPECT_EQ(map.SharedLandmarks({3}, {4}), 6);
  EXPECT_EQ(map.SharedLandmarks({3}, {5}), 3);
  EXPECT_EQ(map.SharedLandmarks({3}, {6}), 0);
  const auto neighbours = map.Neighbours({3}, 4);
  ASSERT_EQ(neighbours.size(), 2u);
  EXPECT_EQ(neighbours[0].first, KeyframeId{4});  // as many as 2, but newer
  ExpectConsistent(map);
}

TEST(Map, MergedLandmarksAnswerToTheirOldName) {
  Map map = MakeMap(4);
  const LandmarkId a = LandmarkId::From({1}, 0);
  const LandmarkId b = LandmarkId::From({4}, 0);
  const LandmarkId c = LandmarkId::From({4}, 1);
  map.MergeLandmark(b, a);
  EXPECT_EQ(map.Resolve(b), a);
  EXPECT_EQ(map.FindLandmark(a)->observations.size(), 4u);
  map.MergeLandmark(a, c);  // c is seen by keyframe 4 already: that observation stays c's own
  EXPECT_EQ(map.Resolve(b), c);
  map.RemoveLandmark(c);
  EXPECT_FALSE(map.Resolve(b).valid());
  ExpectConsistent(map);
}

TEST(Map, RemovedKeyframesLeaveTheDrChainConnected) {
  Map map = MakeMap(6);
  map.SetDrAlpha({4}, 5.0);
  const SE3 T_34 = map.FindKeyframe({4})->frame.dr->T_BaBb;
  const SE3 T_45 = map.FindKeyframe({5})->frame.dr->T_BaBb;
  map.RemoveKeyframe({4}, {3});
  const MapKeyframe& after = *map.FindKeyframe({5});
  EXPECT_EQ(after.frame.previous, KeyframeId{3});
  ASSERT_TRUE(after.frame.dr);
  EXPECT_LT((after.frame.dr->T_BaBb.matrix() - (T_34 * T_45).matrix()).norm(), 1e-12);
  EXPECT_EQ(after.dr_alpha, 5.0);
  EXPECT_EQ(map.FindKeyframe({3})->next, KeyframeId{5});
  ExpectConsistent(map);
}

TEST(Map, RemovedKeyframesLiveOnRelativeToOneThatStays) {
  Map map = MakeMap(6);
  const SE3 T_W4 = map.FindKeyframe({4})->frame.T_WC;
  map.RemoveKeyframe({4}, {3});
  map.RemoveKeyframe({3}, {2});
  const auto removal = map.FindRemoval({4});
  ASSERT_TRUE(removal);
  EXPECT_EQ(removal->parent, KeyframeId{2});
  const SE3 again = map.FindKeyframe({2})->frame.T_WC * removal->T_ParentC;
  EXPECT_LT((again.matrix() - T_W4.matrix()).norm(), 1e-12);
}

// One random change after another; the replica sees only keyframes and updates.
// Keyframes 4 and 5 did not show the world: they go, with the landmarks that they made, and the
// chain leads from 3 to 6.
TEST(Map, WithdrawnKeyframesLeaveWithWhatTheyMapped) {
  Map map = MakeMap(5);
  Map replica = map;
  map.Commit();
  replica.Commit();
  Keyframe after = MakeKeyframe(6);
  after.previous = {3};
  after.dr->utime_begin = {3'000'000};
  after.withdraws = true;
  ASSERT_TRUE(map.AddKeyframe(after));
  EXPECT_EQ(map.FindKeyframe({4}), nullptr);
  EXPECT_EQ(map.FindKeyframe({5}), nullptr);
  EXPECT_EQ(map.FindKeyframe({6})->frame.previous, KeyframeId{3});
  EXPECT_TRUE(map.FindKeyframe({6})->frame.dr);
  EXPECT_EQ(map.FindRemoval({5})->parent, KeyframeId{3});
  EXPECT_FALSE(map.FindKeyframe({6})->frame.withdraws);
  for (const LandmarkId id : map.SortedLandmarkIds()) {
    EXPECT_LE(id.creator(), KeyframeId{3});
    EXPECT_FALSE(map.FindLandmark(id)->observations.empty());
  }
  EXPECT_EQ(map.num_landmarks(), 9u);
  ExpectConsistent(map);
  const MapUpdate update = map.Commit();
  EXPECT_EQ(update.removed_keyframes.size(), 2u);
  ASSERT_TRUE(replica.AddKeyframe(after));
  ASSERT_EQ(replica.Apply(update), Map::Applied::kDone);
  EXPECT_EQ(replica.num_ignored(), 0);
  EXPECT_EQ(replica.Hash(), map.Hash());
}

TEST(Map, OnlyThePieceOfTheKeyframeIsWithdrawn) {
  Map map = MakeMap(3);
  Keyframe other = MakeKeyframe(4);
  other.previous = {};
  other.dr.reset();
  other.piece = {4};
  ASSERT_TRUE(map.AddKeyframe(other));
  Keyframe after = MakeKeyframe(5);
  after.previous = {2};
  after.dr.reset();
  after.withdraws = true;
  ASSERT_TRUE(map.AddKeyframe(after));
  EXPECT_EQ(map.FindKeyframe({3}), nullptr);
  EXPECT_NE(map.FindKeyframe({4}), nullptr);
  // One that names none before it withdraws nothing.
  Keyframe alone = MakeKeyframe(6);
  alone.previous = {};
  alone.dr.reset();
  alone.withdraws = true;
  ASSERT_TRUE(map.AddKeyframe(alone));
  EXPECT_EQ(map.keyframes().size(), 5u);
  ExpectConsistent(map);
}

TEST(Map, AKeyframeThatTellsAnotherFactorCorrectsAllLengths) {
  Map map = MakeMap(2);
  Keyframe third = MakeKeyframe(3);
  third.features[0].depth = 2;
  ASSERT_TRUE(map.AddKeyframe(third));
  Keyframe begins_piece = MakeKeyframe(4);
  begins_piece.previous = {};
  begins_piece.dr.reset();
  begins_piece.piece = {4};
  ASSERT_TRUE(map.AddKeyframe(begins_piece));
  map.Commit();
  Map replica;
  for (const auto& [id, keyframe] : map.keyframes()) {
    ASSERT_TRUE(replica.AddKeyframe(keyframe.frame));
  }
  ASSERT_EQ(replica.Apply(map.Snapshot()), Map::Applied::kDone);
  Keyframe after = MakeKeyframe(5);
  after.previous = {3};
  after.length_factor = 0.8;
  const SE3 first = map.FindKeyframe({1})->frame.T_WC;
  const LandmarkId seen = map.SortedLandmarkIds().front();
  const Landmark before = *map.FindLandmark(seen);
  ASSERT_TRUE(map.AddKeyframe(after));
  ASSERT_TRUE(replica.AddKeyframe(after));
  const auto position = [&](int64_t id) -> Eigen::Vector3d {
    return map.FindKeyframe({id})->frame.T_WC.translation();
  };
  const auto from_first = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return p - first.translation();
  };
  EXPECT_TRUE(from_first(position(3)).isApprox(0.8 * from_first(third.T_WC.translation())));
  EXPECT_TRUE(from_first(map.FindLandmark(seen)->p_W).isApprox(0.8 * from_first(before.p_W)));
  EXPECT_FLOAT_EQ(map.FindKeyframe({3})->frame.features[0].depth, 1.6F);
  EXPECT_TRUE(position(4).isApprox(begins_piece.T_WC.translation())) << "the first of its piece";
  EXPECT_TRUE(position(5).isApprox(after.T_WC.translation())) << "tells its own";
  EXPECT_EQ(map.length_factor(), 0.8);
  ExpectConsistent(map);
  ASSERT_EQ(replica.Apply(map.Commit()), Map::Applied::kDone);
  EXPECT_EQ(replica.Hash(), map.Hash());

  Map read;  // as from a file: the keyframes, then the state
  for (const auto& [id, keyframe] : map.keyframes()) {
    ASSERT_TRUE(read.AddKeyframe(keyframe.frame));
  }
  ASSERT_EQ(read.Apply(map.Snapshot()), Map::Applied::kDone);
  EXPECT_EQ(read.Hash(), map.Hash());
  EXPECT_FLOAT_EQ(read.FindKeyframe({3})->frame.features[0].depth, 1.6F);

  after.id = {6};
  after.length_factor = 0;
  EXPECT_FALSE(map.AddKeyframe(after));
}

TEST(Map, ReplicaFollowsRandomChangesExactly) {
  for (uint64_t seed = 0; seed < 60; ++seed) {
    Map map;
    Map replica;
    for (uint64_t step = 0; step < 60; ++step) {
      CounterRng rng(seed, 1, step);
      const auto pick_keyframe = [&] {
        auto it = map.keyframes().begin();
        std::advance(it, rng.Below(static_cast<uint32_t>(map.keyframes().size())));
        return it->first;
      };
      const bool insert = map.keyframes().size() < 3 || rng.Below(6) == 0;
      if (insert) {
        ASSERT_EQ(replica.Apply(map.Commit()), Map::Applied::kDone);
        ASSERT_EQ(replica.Hash(), map.Hash()) << "seed " << seed << " step " << step;
      }
      const std::vector<LandmarkId> ids = map.SortedLandmarkIds();
      const auto pick_landmark = [&] { return ids[rng.Below(static_cast<uint32_t>(ids.size()))]; };
      if (insert) {
        const Keyframe keyframe = MakeKeyframe(map.newest_keyframe().value + 1, 20);
        ASSERT_TRUE(map.AddKeyframe(keyframe));
        ASSERT_TRUE(replica.AddKeyframe(keyframe));
        for (int i = 0; i < 5; ++i) {
          const LandmarkId id = LandmarkId::From(keyframe.id, i);
          map.AddLandmark(id).p_W = {rng.Normal(), rng.Normal(), rng.Normal()};
          map.AddObservation(id, {keyframe.id, i});
        }
      } else if (!ids.empty()) {
        for (int i = 0; i < 10; ++i) {
          map.AddObservation(pick_landmark(), {pick_keyframe(), static_cast<int>(rng.Below(20))});
        }
        const LandmarkId a = pick_landmark();
        const LandmarkId b = pick_landmark();
        switch (rng.Below(5)) {
          case 0:
            if (a != b) map.MergeLandmark(a, b);
            break;
          case 1:
            map.RemoveLandmark(a);
            break;
          case 2: {
            const KeyframeId gone = pick_keyframe();
            const KeyframeId parent = pick_keyframe();
            if (gone != parent) map.RemoveKeyframe(gone, parent);
            break;
          }
          case 3:
            map.SetPose(pick_keyframe(), SE3(ExpSO3({rng.Normal(), 0, 0}), {rng.Normal(), 0, 0}));
            break;
          default:
            map.MutableLandmark(a).p_W.x() += 1;
            map.SetDrAlpha(pick_keyframe(), rng.Uniform());
            break;
        }
      }
    }
    ASSERT_EQ(replica.Apply(map.Commit()), Map::Applied::kDone);
    ASSERT_EQ(replica.Hash(), map.Hash()) << "seed " << seed;
    ExpectConsistent(map);
    EXPECT_EQ(replica.num_ignored(), 0);

    // The snapshot alone, on top of the keyframes, gives the same map again.
    Map restored;
    for (const auto& [id, keyframe] : map.keyframes()) {
      ASSERT_TRUE(restored.AddKeyframe(keyframe.frame));
    }
    ASSERT_EQ(restored.Apply(map.Snapshot()), Map::Applied::kDone);
    EXPECT_EQ(restored.Hash(), map.Hash()) << "seed " << seed;
  }
}

TEST(Map, RefusesAKeyframeThatIsNotAfterTheOneBeforeIt) {
  Map map = MakeMap(3);
  Keyframe keyframe = MakeKeyframe(4);
  keyframe.utime = map.FindKeyframe({3})->frame.utime;
  EXPECT_FALSE(map.AddKeyframe(keyframe));
  EXPECT_TRUE(map.AddKeyframe(MakeKeyframe(4)));
}

TEST(Map, RefusesAnUpdateThatDoesNotFollow) {
  Map map = MakeMap(3);
  Map replica;
  const MapUpdate first = map.Commit();
  map.SetPose({1}, SE3());
  const MapUpdate second = map.Commit();
  EXPECT_EQ(replica.Apply(second), Map::Applied::kGap);
  EXPECT_EQ(replica.Hash(), Map().Hash());
  EXPECT_EQ(replica.Apply(first), Map::Applied::kDone);
  EXPECT_EQ(replica.Apply(second), Map::Applied::kDone);
}

MapUpdate Next(const Map& map) {
  MapUpdate out;
  out.base_revision = map.revision();
  out.revision = out.base_revision + 1;
  out.newest_keyframe = map.newest_keyframe();
  return out;
}

TEST(Map, AFeatureBelongsToOneLandmark) {
  Map map = MakeMap(3);
  map.Commit();
  MapUpdate thief = Next(map);
  thief.landmarks.push_back(*map.FindLandmark(LandmarkId::From({1}, 0)));
  thief.landmarks[0].id = LandmarkId::From({3}, 9);
  const auto stolen = thief.landmarks[0].observations.size();
  EXPECT_EQ(map.Apply(thief), Map::Applied::kDone);
  EXPECT_EQ(map.num_ignored(), std::ssize(thief.landmarks[0].observations));
  EXPECT_EQ(map.FindLandmark(LandmarkId::From({1}, 0))->observations.size(), stolen);
  ExpectConsistent(map);
}

TEST(Map, WithinAnUpdateAFeaturePassesFromOneLandmarkToAnother) {
  for (const bool to_the_first : {false, true}) {
    Map map = MakeMap(3);
    map.Commit();
    MapUpdate update = Next(map);
    for (const int i : {0, 1}) {
      update.landmarks.push_back(*map.FindLandmark(LandmarkId::From({1}, i)));
    }
    auto& from = update.landmarks[to_the_first ? 1 : 0].observations;
    auto& to = update.landmarks[to_the_first ? 0 : 1].observations;
    to.back() = from.back();
    from.pop_back();
    EXPECT_EQ(map.Apply(update), Map::Applied::kDone);
    EXPECT_EQ(map.num_ignored(), 0);
    for (const LandmarkUpdate& landmark : update.landmarks) {
      EXPECT_EQ(map.FindLandmark(landmark.id)->observations, landmark.observations);
    }
    ExpectConsistent(map);
  }
}

TEST(Map, IgnoresAndCountsContradictionsInAnUpdate) {
  Map map = MakeMap(3);
  map.Commit();
  MapUpdate bad = Next(map);
  bad.keyframes.push_back({{}, {}, SE3()});
  LandmarkUpdate landmark;
  landmark.id = LandmarkId::From({1}, 0);
  landmark.observations = {{{2}, 0}, {{1}, -4}, {{99}, 1}, {{2}, 3}};
  bad.landmarks.push_back(landmark);
  landmark.id = LandmarkId::From({1}, 1);
  landmark.p_W.x() = std::numeric_limits<double>::quiet_NaN();
  bad.landmarks.push_back(landmark);
  landmark.id = LandmarkId::From({4}, 0);  // a name that keyframe 4 will give
  landmark.p_W.setZero();
  bad.landmarks.push_back(landmark);
  bad.keyframes.push_back({{3}, {1}, SE3()});  // was taken at another time
  bad.removed_keyframes.push_back({{2}, {2}, SE3()});
  bad.removed_keyframes.push_back({{2}, {9}, SE3()});
  bad.removed_keyframes.push_back({{1}, {3}, SE3()});
  bad.dr_edges.push_back({{8}, {9}, 1});
  bad.merged_landmarks.push_back({LandmarkId::From({2}, 0), LandmarkId::From({2}, 0)});
  EXPECT_EQ(map.Apply(bad), Map::Applied::kDone);
  EXPECT_GE(map.num_ignored(), 9);
  EXPECT_FALSE(map.Resolve(LandmarkId::From({2}, 0)).valid());
  EXPECT_EQ(map.FindKeyframe({1}), nullptr);
  ExpectConsistent(map);
}

TEST(Compose, IsTheMotionOverBothIntervals) {
  const World world({});
  const DrIncrement ab = world.Dr(3);
  const DrIncrement bc = world.Dr(4);
  const DrIncrement ac = Compose(ab, bc);
  EXPECT_EQ(ac.utime_begin, ab.utime_begin);
  EXPECT_EQ(ac.utime_end, bc.utime_end);
  EXPECT_LT((ac.T_BaBb.matrix() - (ab.T_BaBb * bc.T_BaBb).matrix()).norm(), 1e-12);
  // Rotations of the first part move the end by the length of the second.
  EXPECT_GT(ac.cov(1, 1), ab.cov(1, 1) + bc.cov(1, 1));
}

}  // namespace
}  // namespace gw::backend

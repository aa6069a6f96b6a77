// The tracker in a synthetic room, where it does not know where it is in the map.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "frontend/core/place/recovery.h"
#include "frontend/core/tracking/tracker_test_room.h"

namespace gw::frontend {
namespace {

PlaceMatch Answer(const PlaceQuery& query, const SE3& T_WC) {
  PlaceMatch match;
  match.utime = query.utime;
  match.query_seq = query.seq;
  match.found = true;
  match.T_WC = T_WC;
  match.cov_T_WC = Matrix6d::Identity() * 1e-4;
  match.num_sights = 100;
  match.map_revision = 1;
  match.keyframe = {1};
  return match;
}

// The map that a drive has made, as its back-end would send it: the landmarks where the keyframes
// placed them.
MapUpdate Saved(const World& world, const std::vector<Keyframe>& keyframes) {
  MapUpdate map;
  map.snapshot = true;
  map.revision = 1;
  std::map<LandmarkId, LandmarkUpdate> landmarks;
  for (const Keyframe& k : keyframes) {
    map.newest_keyframe = k.id;
    map.keyframes.push_back({k.id, k.utime, k.T_WC});
    for (size_t i = 0; i < k.features.size(); ++i) {
      if (!k.landmarks[i].valid()) continue;
      LandmarkUpdate& l = landmarks[k.landmarks[i]];
      l.observations.push_back({k.id, static_cast<int32_t>(i)});
      if (l.id.valid()) continue;
      const Feature& f = k.features[i];
      const Eigen::Vector3d p_C = world.geometry().rectified.Unproject(f.u, f.v, f.depth);
      l.id = k.landmarks[i];
      l.p_W = k.T_WC * p_C;
      l.normal_W = k.T_WC.rotation() * p_C.normalized();
      l.max_distance = static_cast<float>(p_C.norm());  // all features are of level 0
      l.min_distance = l.max_distance / 3.6F;
      l.descriptor = k.descriptors[i];
    }
  }
  for (const auto& [id, landmark] : landmarks) map.landmarks.push_back(landmark);
  return map;
}

bool ClaimsAPlace(const FramePose& pose) {
  return pose.cov_T_WB.diagonal().head<3>().sum() < 1.0;
}

// A start in the map of a first round. The views near the origin of W are exactly those that the
// robot sees now, but nobody has told it that it is there: another room may look the same.
class StartInASavedMap : public testing::Test {
 protected:
  StartInASavedMap() : map_(Saved(world_, Drive(Variant::kFull, 400, 0, 0, 1.0).keyframes)) {}

  TrackerOutput See(Tracker& tracker, int i) {
    if (has_dr_) {
      DrState state;
      state.utime = {i * kFrameUs};
      state.seq = i + 1;
      state.T_OB = TruePose(i * kFrameUs * 1e-6);
      EXPECT_TRUE(tracker.Push(state));
    }
    return tracker.Track({i * kFrameUs}, i + 1,
                         world_.See(TruePose(i * kFrameUs * 1e-6), 1000 + i, false));
  }

  static Tracker Make(const World& world, Variant variant) {
    FrontendConfig config;
    config.variant = variant;
    return *Tracker::Create(config, world.geometry());
  }

  const World world_;
  const MapUpdate map_;
  bool has_dr_ = true;
};

TEST_F(StartInASavedMap, ClaimsNothingUntilThreeAnswersAgree) {
  Tracker tracker = Make(world_, Variant::kFull);
  // It is not known either whether there is a map.
  EXPECT_FALSE(ClaimsAPlace(See(tracker, 0).pose));
  EXPECT_TRUE(tracker.Push(map_));
  std::vector<PlaceQuery> asked;
  int i = 1;
  for (; asked.size() < 3; ++i) {
    ASSERT_LT(i, 60);
    const TrackerOutput out = See(tracker, i);
    EXPECT_FALSE(ClaimsAPlace(out.pose)) << i;
    EXPECT_EQ(out.pose.status, TrackingStatus::kRecovering);
    EXPECT_EQ(out.pose.reason, TrackingReason::kPlaceUnknown);
    EXPECT_FALSE(out.keyframe) << i;
    if (out.query) asked.push_back(*out.query);
  }
  for (const PlaceQuery& query : asked) {
    tracker.Push(Answer(query, TruePose(query.utime.seconds()) * world_.geometry().rectified.T_BC));
  }
  for (; i < 60; ++i) {
    const TrackerOutput out = See(tracker, i);
    EXPECT_TRUE(ClaimsAPlace(out.pose)) << i;
    EXPECT_GT(out.pose.num_inliers, 100) << i;
    const SE3 error = TruePose(i * kFrameUs * 1e-6).inverse() * out.pose.T_WB;
    EXPECT_LT(error.translation().norm(), 0.05) << i;
    EXPECT_EQ(out.pose.reason, TrackingReason::kNone) << i;
  }
}

// Three answers that agree, but the image does not look like that.
TEST_F(StartInASavedMap, AConfirmedPlaceThatIsNotSeenIsNotClaimed) {
  Tracker tracker = Make(world_, Variant::kFull);
  EXPECT_TRUE(tracker.Push(map_));
  const SE3 wrong(ExpSO3({0, 0, 2.0}), {0.5, 0.5, 0});
  for (int i = 0; i < 60; ++i) {
    const TrackerOutput out = See(tracker, i);
    EXPECT_FALSE(ClaimsAPlace(out.pose)) << i;
    if (!out.query) continue;
    tracker.Push(Answer(*out.query, wrong * TruePose(out.query->utime.seconds()) *
                                        world_.geometry().rectified.T_BC));
  }
}

TEST_F(StartInASavedMap, WithoutDeadReckoningSeveralImagesHaveToAgree) {
  has_dr_ = false;
  Tracker tracker = Make(world_, Variant::kNone);
  EXPECT_TRUE(tracker.Push(map_));
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(ClaimsAPlace(See(tracker, i).pose), i + 1 >= Recovery::kContradictingImages) << i;
  }
}

TEST_F(StartInASavedMap, APoseOfTheDrProcessIsAPlaceToStartFrom) {
  Pose pose;
  pose.has_map = true;
  pose.cov_T_WB = Matrix6d::Identity() * 1e-4;
  Tracker tracker = Make(world_, Variant::kFull);
  EXPECT_TRUE(tracker.Push(map_));
  tracker.Push(pose);
  EXPECT_TRUE(ClaimsAPlace(See(tracker, 0).pose));
  EXPECT_GT(See(tracker, 1).pose.num_inliers, 100);

  // ... but not one that does not know its place itself.
  pose.cov_T_WB = CovarianceOfNoIdea();
  Tracker other = Make(world_, Variant::kFull);
  EXPECT_TRUE(other.Push(map_));
  other.Push(pose);
  EXPECT_FALSE(ClaimsAPlace(See(other, 0).pose));
  EXPECT_EQ(See(other, 1).pose.reason, TrackingReason::kPlaceUnknown);
}

// After one round of the circle the robot is set down on its other side; dead reckoning does not
// notice. A back-end that knows the place answers each question before the next image.
TEST(Tracker, CarriedAwayItClaimsNothingAsksAndFollowsTheAnswers) {
  const World world;
  FrontendConfig config;
  config.variant = Variant::kFull;
  Tracker tracker = *Tracker::Create(config, world.geometry());
  MapUpdate empty;
  empty.snapshot = true;
  EXPECT_TRUE(tracker.Push(empty));
  constexpr int kCarried = 400;
  const auto true_pose = [](int i) {
    return TruePose((i < kCarried ? i : i + 189) * kFrameUs * 1e-6);
  };
  SE3 T_OB;
  std::optional<PlaceMatch> answer;
  int found_after = -1;
  std::optional<Keyframe> first_there;
  for (int i = 0; i < kCarried + 90; ++i) {
    const SE3 T_WB = true_pose(i);
    if (i > 0 && i != kCarried) T_OB = T_OB * (true_pose(i - 1).inverse() * T_WB);
    DrState state;
    state.utime = {i * kFrameUs};
    state.seq = i + 1;
    state.T_OB = T_OB;
    EXPECT_TRUE(tracker.Push(state));
    if (answer) tracker.Push(*answer);
    const TrackerOutput out = tracker.Track({i * kFrameUs}, i + 1, world.See(T_WB, i, false));
    answer.reset();
    if (out.query) {
      EXPECT_GE(i, kCarried);
      answer = Answer(*out.query, T_WB * world.geometry().rectified.T_BC);
    }
    if (i < kCarried) continue;
    if ((out.pose.T_WB.translation() - T_WB.translation()).norm() > 0.5) {
      EXPECT_GT(out.pose.cov_T_WB.diagonal().head<3>().sum(), 1.0) << i;
      EXPECT_FALSE(out.keyframe) << i;
    } else if (found_after < 0) {
      found_after = i - kCarried;
    }
    if (out.keyframe && !first_there) first_there = out.keyframe;
  }
  EXPECT_GT(found_after, 0);
  EXPECT_LT(found_after, 30);  // three answers, one every 0.2 s
  ASSERT_TRUE(first_there);
  EXPECT_FALSE(first_there->dr);  // it does not lead from where the robot was lifted
}

// What the back-end makes of keyframes of a piece when it joins it to the map: all of it moves.
MapUpdate Joined(const std::vector<Keyframe>& piece, const SE3& T_MapPiece,
                 const RectifiedCamera& camera) {
  MapUpdate update;
  update.revision = 1;
  update.newest_keyframe = piece.back().id;
  for (const Keyframe& keyframe : piece) {
    const SE3 T_WC = T_MapPiece * keyframe.T_WC;
    update.keyframes.push_back({keyframe.id, keyframe.utime, T_WC});
    for (size_t i = 0; i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmarks[i];
      if (!id.valid() || id.creator() != keyframe.id) continue;
      const Feature& f = keyframe.features[i];
      LandmarkUpdate landmark;
      landmark.id = id;
      landmark.p_W = T_WC * camera.Unproject(f.u, f.v, f.depth);
      landmark.normal_W = (landmark.p_W - T_WC.translation()).normalized();
      landmark.max_distance = 2 * f.depth;
      landmark.min_distance = f.depth / 4;
      landmark.descriptor = keyframe.descriptors[i];
      landmark.observations = {{keyframe.id, static_cast<int32_t>(i)}};
      update.landmarks.push_back(landmark);
    }
  }
  return update;
}

// After two seconds the robot is set down where it has not been yet, and nobody knows the place. It
// maps on there in a piece of its own, claims nothing, and goes on in the map when the piece is
// joined to it.
TEST(Tracker, CarriedToUnmappedGroundItMapsOnInAPieceOfItsOwn) {
  const World world;
  const RectifiedCamera& camera = world.geometry().rectified;
  FrontendConfig config;
  config.variant = Variant::kFull;
  Tracker tracker = *Tracker::Create(config, world.geometry());
  MapUpdate empty;
  empty.snapshot = true;
  EXPECT_TRUE(tracker.Push(empty));
  constexpr int kCarried = 60, kJoined = 210, kImages = 240;
  const auto true_pose = [](int i) {
    return TruePose((i < kCarried ? i : i + 189) * kFrameUs * 1e-6);
  };
  SE3 T_OB, T_WO;  // T_WO: by which the piece lies wrong
  std::vector<Keyframe> piece;
  int begun = -1;
  for (int i = 0; i < kImages; ++i) {
    const SE3 T_WB = true_pose(i);
    if (i > 0 && i != kCarried) T_OB = T_OB * (true_pose(i - 1).inverse() * T_WB);
    if (i == kCarried) T_WO = T_WB * T_OB.inverse();
    DrState state;
    state.utime = {i * kFrameUs};
    state.seq = i + 1;
    state.T_OB = T_OB;
    EXPECT_TRUE(tracker.Push(state));
    if (i == kJoined) {
      EXPECT_TRUE(tracker.Push(Joined(piece, T_WO, camera)));
    }
    const TrackerOutput out = tracker.Track({i * kFrameUs}, i + 1, world.See(T_WB, i, false));
    const double claimed_m = std::sqrt(out.pose.cov_T_WB.diagonal().head<3>().maxCoeff());
    if (i >= kCarried && i < kJoined) {
      EXPECT_EQ(out.pose.status, TrackingStatus::kRecovering) << i;
      EXPECT_GT(claimed_m, 5) << i;
      if (out.keyframe) {
        if (piece.empty()) begun = i;
        piece.push_back(*out.keyframe);
      }
      // In its own frame, which is that of dead reckoning, it knows where it is.
      if (!piece.empty()) {
        EXPECT_LT((out.pose.T_WB.translation() - T_OB.translation()).norm(), 0.1) << i;
      }
    } else if (i >= kJoined) {
      EXPECT_LT((out.pose.T_WB.translation() - T_WB.translation()).norm(), 0.1) << i;
      EXPECT_LT(claimed_m, 0.2) << i;
      EXPECT_EQ(out.pose.status == TrackingStatus::kRecovering, i == kJoined) << i;
      EXPECT_FALSE(out.keyframe && out.keyframe->piece.valid()) << i;
    }
  }
  ASSERT_GT(piece.size(), 2u);
  EXPECT_GE(begun - kCarried, 90);  // 3 s
  EXPECT_LT(begun - kCarried, 120);
  EXPECT_EQ(piece[0].piece, piece[0].id);
  EXPECT_FALSE(piece[0].previous.valid());
  EXPECT_EQ(piece[1].piece, piece[0].id);
  EXPECT_EQ(piece[1].previous, piece[0].id);
  EXPECT_TRUE(piece[1].dr);
}

}  // namespace
}  // namespace gw::frontend

#include "frontend/core/tracking/camera_track.h"

#include <gtest/gtest.h>

#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

SE3 Pose(double x, double yaw = 0) {
  return SE3(ExpSO3({0, 0, yaw}), {x, 0, 0});
}

// A map of two keyframes, 1 of the map itself and 5 of a piece of its own, and a camera 0.5 m
// before the reference.
class CameraTrackTest : public testing::Test {
 protected:
  CameraTrackTest() : track_(FrontendConfig{}), map_(TestCamera(6), Pyramid(1.2, 8)) {
    MapUpdate update;
    update.revision = 1;
    update.snapshot = true;
    update.keyframes = {{KeyframeId{1}, Utime{1}, Pose(1), {}},
                        {KeyframeId{5}, Utime{5}, Pose(7), KeyframeId{5}}};
    EXPECT_TRUE(map_.Apply(update));
    track_.uncertainty.Reset(Matrix6d::Identity() * 0.04);
  }

  void Express(int64_t reference) {
    track_.reference = KeyframeId{reference};
    track_.T_WC = *map_.KeyframePose(track_.reference) * Pose(0.5);
    map_.Use(*map_.PieceOf(track_.reference));
  }

  CameraTrack::Correction Follow(MapUpdate update) {
    const SE3 T_WK_before = *map_.KeyframePose(track_.reference);
    update.base_revision = map_.revision();
    update.revision = update.base_revision + 1;
    EXPECT_TRUE(map_.Apply(update));
    return track_.FollowReference(T_WK_before, update, &map_);
  }

  CameraTrack track_;
  LocalMap map_;
};

void ExpectPoseNear(const SE3& expected, const SE3& actual) {
  EXPECT_LT((expected.inverse() * actual).Log().norm(), 1e-9);
}

TEST_F(CameraTrackTest, ThePoseGoesWithItsKeyframe) {
  Express(1);
  track_.anchors.Remember(Utime{1}, Pose(0), Matrix6d::Identity() * 1e-6);
  MapUpdate update;
  update.keyframes = {{KeyframeId{1}, Utime{1}, Pose(2, 0.3), {}}};
  const SE3 before = track_.T_WC;
  const auto correction = Follow(update);
  EXPECT_FALSE(correction.joined);
  ExpectPoseNear(Pose(2, 0.3) * Pose(0.5), track_.T_WC);
  ExpectPoseNear(correction.T * before, track_.T_WC);
  ExpectPoseNear(correction.T, track_.anchors.From(Utime{1})->T_WO);
}

TEST_F(CameraTrackTest, AKeyframeThatIsGoneIsReplacedByItsParent) {
  Express(5);
  MapUpdate update;
  update.keyframes = {{KeyframeId{1}, Utime{1}, Pose(1), KeyframeId{5}}};
  update.removed_keyframes = {{KeyframeId{5}, KeyframeId{1}, Pose(3)}};
  Follow(update);
  EXPECT_EQ(track_.reference, KeyframeId{1});
  ExpectPoseNear(Pose(1) * Pose(3) * Pose(0.5), track_.T_WC);
}

TEST_F(CameraTrackTest, ThePoseGoesWithItsPieceIntoTheMap) {
  Express(5);
  MapUpdate update;
  update.keyframes = {{KeyframeId{5}, Utime{5}, Pose(2, 1), {}}};
  EXPECT_TRUE(Follow(update).joined);
  EXPECT_FALSE(map_.piece().valid());
  ExpectPoseNear(Pose(2, 1) * Pose(0.5), track_.T_WC);
  // As sure as before: the step is no error of the pose.
  EXPECT_EQ(track_.uncertainty.cov(), Matrix6d::Identity() * 0.04);
}

// Vision stood still for half a second while dead reckoning drove on.
TEST_F(CameraTrackTest, RewoundItIsWhereDeadReckoningLeadsFromThen) {
  const FrontendConfig config;
  const RectifiedCamera camera = TestCamera(6);
  MotionModel motion(camera, ImuCalibration(), config);
  for (int i = 0; i <= 20; ++i) {
    DrState state;
    state.utime = Utime{} + Milliseconds(100 * i);
    state.seq = i + 1;
    state.T_OB = Pose(0.1 * i);
    state.cov_twist_white = Matrix6d::Identity() * 1e-4;
    ASSERT_TRUE(motion.Push(state));
  }
  const Matrix6d sure = Matrix6d::Identity() * 1e-8;
  for (int i = 0; i <= 10; ++i) {
    track_.utime = Utime{} + Milliseconds(100 * i);
    track_.T_WC = Pose(0.1 * std::min(i, 5)) * camera.T_BC;
    track_.uncertainty.Reset(sure);
    track_.RememberAnchor(motion);
  }
  // The half metre since then is far beyond what either is unsure of; the way until then is not.
  EXPECT_FALSE(track_.AgreesWithDr(Utime{} + Milliseconds(500), motion));
  EXPECT_FALSE(track_.AgreesWithDr(Utime{} - Milliseconds(500), motion));  // not remembered
  const SE3 held = track_.T_WC;
  track_.T_WC = Pose(1.01) * camera.T_BC;
  EXPECT_TRUE(track_.AgreesWithDr(Utime{} + Milliseconds(500), motion));
  track_.T_WC = held;
  track_.Rewind(Utime{} + Milliseconds(500), &motion);
  ExpectPoseNear(Pose(1) * camera.T_BC, track_.T_WC);
  // As sure as it was then, and no surer than dead reckoning since.
  const double variance = track_.uncertainty.cov().diagonal().head<3>().maxCoeff();
  EXPECT_GT(variance, 0.9 * 0.5e-4);
  EXPECT_LT(variance, 2 * 0.5e-4);
}

// Keyframe 1 is the map's first one, 6 was made in the dark, and sees new landmarks.
TEST_F(CameraTrackTest, APoseIsNoSurerThanWhatItSees) {
  Keyframe dark;
  dark.id = KeyframeId{6};
  dark.T_WC = Pose(7);
  dark.features.resize(1);
  dark.features[0].depth = 4;
  dark.descriptors.resize(1);
  dark.landmarks = {LandmarkId::From(dark.id, 0)};
  map_.AddKeyframe(dark);
  track_.T_WC = Pose(7);
  track_.KeyframeMade(dark.id);
  FoundPose found;
  found.estimate.T_WC = Pose(9);
  found.estimate.vision_information = Matrix6d::Identity() * 1e8;
  found.reference = dark.id;
  found.landmarks = dark.landmarks;
  FeatureFrame frame;
  frame.features.resize(1);
  frame.descriptors.resize(1);
  track_.Take(found, frame, map_);
  // 2 m ahead of it: its doubt of the heading, 0.2 rad, is one of the place.
  EXPECT_NEAR(track_.cov()(0, 0), 0.04, 1e-3);
  EXPECT_NEAR(track_.cov()(1, 1), 0.04 + 4 * 0.04, 1e-3);
  // Dark again it is as sure as it was, 3 m ahead; and so is a keyframe that is made there.
  track_.GoOn(Pose(1), Pose(10));
  EXPECT_NEAR(track_.doubt(1, 1), 0.04 + 9 * 0.04, 1e-3);
  track_.KeyframeMade(KeyframeId{7});
  EXPECT_NEAR(track_.doubts.At(KeyframeId{7}, SE3())(1, 1), 0.04 + 9 * 0.04, 1e-3);
}

TEST_F(CameraTrackTest, APieceBeginsWhereTheCameraIs) {
  Express(1);
  track_.points.push_back({LandmarkId::From(KeyframeId{1}, 0), {}, 0});
  track_.chain.Skip(KeyframeId{5});
  const SE3 before = track_.T_WC;
  track_.BeginPiece(&map_);
  EXPECT_EQ(map_.piece(), KeyframeId{6});
  EXPECT_TRUE(track_.points.empty());
  EXPECT_LT(track_.uncertainty.cov().trace(), 1e-9);
  ExpectPoseNear(before, track_.T_WC);
}

}  // namespace
}  // namespace gw::frontend

#include "frontend/core/map/keyframe_doubt.h"

#include <gtest/gtest.h>

#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

constexpr double kStep = 1e-4;  // variance of a keyframe's pose in the map around it, per axis

LandmarkId Landmark(int64_t keyframe) {
  return LandmarkId::From(KeyframeId{keyframe}, 0);
}

// Keyframes 1, 2, ... that begin a landmark each. All stand in the same place, so that a variance
// is the same seen from each of them.
class KeyframeDoubtTest : public testing::Test {
 protected:
  KeyframeDoubtTest() : map_(TestCamera(4), Pyramid(1.2, 8)) {}

  // A keyframe that was found among the landmark of another one.
  void Make(int64_t id, int64_t from, double variance = kStep) {
    Keyframe k;
    k.id = {id};
    k.features.resize(1);
    k.features[0].depth = 4;
    k.descriptors.resize(1);
    k.landmarks = {Landmark(id)};
    map_.AddKeyframe(k);
    const Matrix6d around = doubt_.Among({Landmark(from)}, map_, SE3()).value_or(Matrix6d::Zero());
    doubt_.Add(k.id, around + variance * Matrix6d::Identity());
  }
  void Walk(int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; ++id) Make(id, id - 1);
  }
  double Variance(int64_t id) const { return doubt_.At(KeyframeId{id}, SE3())(0, 0); }
  void Close(int64_t from, int64_t to) {
    doubt_.Close({KeyframeId{from}, KeyframeId{to}, true, SE3()}, map_);
  }

  LocalMap map_;
  KeyframeDoubt doubt_;
};

TEST_F(KeyframeDoubtTest, ErrorsAddUpWhereLandmarksGiveWay) {
  Walk(1, 20);
  for (int id = 1; id <= 20; ++id) EXPECT_NEAR(Variance(id), id * kStep, 1e-12);
  // A keyframe that still sees the first landmark is as sure as the second.
  Make(21, 1);
  EXPECT_NEAR(Variance(21), 2 * kStep, 1e-12);
  // What is seen half from here, half from there, is between.
  EXPECT_NEAR((*doubt_.Among({Landmark(1), Landmark(19)}, map_, SE3()))(0, 0), 10 * kStep, 1e-12);
}

TEST_F(KeyframeDoubtTest, AnErrorOfHeadingIsOneOfThePlaceFartherOn) {
  Make(1, 0);
  const SE3 ahead(Eigen::Quaterniond::Identity(), {10, 0, 0});
  EXPECT_NEAR(doubt_.At(KeyframeId{1}, ahead)(1, 1), kStep + 100 * kStep, 1e-12);
}

TEST_F(KeyframeDoubtTest, OfLandmarksThatAreNotThereNothingIsKnown) {
  Make(1, 0);
  EXPECT_FALSE(doubt_.Among({}, map_, SE3()));
  EXPECT_FALSE(doubt_.Among({Landmark(7), LandmarkId{}}, map_, SE3()));
  EXPECT_TRUE(doubt_.At(KeyframeId{7}, SE3()).isZero());
}

TEST_F(KeyframeDoubtTest, ALoopTiesBothEndsOfTheWalk) {
  Walk(1, 25);
  Close(21, 1);
  EXPECT_NEAR(Variance(1), kStep, 1e-12);
  EXPECT_NEAR(Variance(6), kStep + 5 * 0.75 * kStep, 1e-12);
  EXPECT_NEAR(Variance(11), kStep + 10 * 0.5 * kStep, 1e-12);
  EXPECT_NEAR(Variance(21), kStep, 1e-12);
  EXPECT_NEAR(Variance(25), kStep + 4 * kStep, 1e-12);
  // A second one inside takes no more away than it knows, and gives nothing back.
  Close(16, 6);
  EXPECT_NEAR(Variance(6), kStep + 5 * 0.75 * kStep, 1e-12);
  EXPECT_LE(Variance(11), kStep + 10 * 0.5 * kStep + 1e-12);
  EXPECT_GE(Variance(11), Variance(6) - 1e-12);
  EXPECT_NEAR(Variance(21), kStep, 1e-12);
}

TEST_F(KeyframeDoubtTest, ALoopOfKeyframesThatAreGoneChangesNothing) {
  Walk(1, 5);
  doubt_.Remove(KeyframeId{5});
  Close(5, 1);
  EXPECT_NEAR(Variance(4), 4 * kStep, 1e-12);
}

// In the dark every keyframe has all the drift since vision was lost.
TEST_F(KeyframeDoubtTest, ADarkSpanWeighsInTheWalkByItsDrift) {
  Walk(1, 10);
  Make(11, 10, 100 * kStep);
  Walk(12, 21);
  Close(21, 1);
  EXPECT_LT(Variance(10), kStep + 9 * kStep);
  EXPECT_NEAR(Variance(11), kStep + 109 * 10.0 / 119 * kStep, 1e-10);
}

}  // namespace
}  // namespace gw::frontend

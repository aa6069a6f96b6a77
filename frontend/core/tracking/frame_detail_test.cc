#include "frontend/core/tracking/frame_detail.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

// Camera looks along x of the body: z of C is x of B, x of C is -y of B.
SE3 LooksForward() {
  Eigen::Matrix3d R_BC;
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(R_BC), Eigen::Vector3d::Zero()};
}

TEST(PriorShare, FollowsTheAxesOfTheBody) {
  // Vision that knows everything but the way along its optical axis, which is x of the body.
  Vector6d vision = Vector6d::Constant(99.0);
  vision[2] = 0;
  const Matrix6d H_v = vision.asDiagonal();
  const Vector6d share = PriorShare(H_v, Matrix6d::Identity(), LooksForward());
  EXPECT_NEAR(share[0], 1.0, 1e-9);
  for (int i = 1; i < 6; ++i) EXPECT_NEAR(share[i], 0.01, 1e-9) << i;
}

TEST(PriorShare, IsZeroWithoutAPrior) {
  EXPECT_TRUE(PriorShare(Matrix6d::Identity(), Matrix6d::Zero(), SE3()).isZero(0));
}

TEST(FrameDetail, TellsInliersOutliersAndNewLandmarksApart) {
  FeatureFrame frame;
  frame.features.resize(4);
  FoundPose found;
  found.landmarks = {LandmarkId{7}, LandmarkId{}, LandmarkId{}, LandmarkId{}};
  found.outlier = {0, 1, 0, 0};
  found.estimate.vision_information.setIdentity();
  found.estimate.prior_information.setIdentity();
  found.scale = {1.0, 1.0};
  FrameDetail detail = ExplainFrame(
      {.frame = &frame, .found = &found, .vision = true, .from_dr = true}, DrWeightConfig());
  Keyframe keyframe;
  keyframe.id = {3};
  keyframe.landmarks = {LandmarkId{7}, LandmarkId{}, LandmarkId::From({3}, 2), LandmarkId{}};
  MarkNewLandmarks(keyframe, &detail);
  ASSERT_EQ(detail.features.size(), 4u);
  EXPECT_EQ(detail.features[0].fate, FeatureFate::kInlier);
  EXPECT_EQ(detail.features[1].fate, FeatureFate::kOutlier);
  EXPECT_EQ(detail.features[2].fate, FeatureFate::kNew);
  EXPECT_EQ(detail.features[3].fate, FeatureFate::kUnmatched);
  EXPECT_NEAR(detail.dr_share[0], 0.5, 1e-12);
}

TEST(FrameDetail, WithoutVisionDeadReckoningIsAll) {
  FeatureFrame frame;
  FoundPose found;
  const FrameDetail detail = ExplainFrame(
      {.frame = &frame, .found = &found, .vision = false, .from_dr = true}, DrWeightConfig());
  EXPECT_EQ(detail.bound, AlphaBound::kAlphaMax);
  EXPECT_TRUE(detail.dr_share.isOnes());
}

}  // namespace
}  // namespace gw::frontend

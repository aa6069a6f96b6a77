#include "frontend/core/tracking/keyframe_chain.h"

#include <gtest/gtest.h>

#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

Utime Second(double s) {
  return Utime{} + DurationFromSeconds(s);
}

class KeyframeChainTest : public testing::Test {
 protected:
  KeyframeChainTest()
      : chain_(FrontendConfig{}), motion_(TestCamera(6), ImuCalibration{}, FrontendConfig{}) {
    // Dead reckoning that drives straight on at 1 m/s.
    for (int i = 0; i <= 200; ++i) {
      DrState state;
      state.utime = Second(0.1 * i);
      state.seq = i + 1;
      state.T_OB = SE3(Eigen::Quaterniond::Identity(), {0.1 * i, 0, 0});
      state.cov_twist_white = Matrix6d::Identity() * 1e-6;
      EXPECT_TRUE(motion_.Push(state));
    }
  }

  Keyframe MakeAt(double s) {
    FramePose report;
    report.utime = Second(s);
    return chain_.Make({FeatureFrame{}, FoundPose{}, report, SE3(), Matrix6d::Identity(), {}, 0},
                       motion_);
  }

  bool Due() const { return chain_.WantsNext(Second(9), FeatureFrame{}, FoundPose{}, 0); }

  KeyframeChain chain_;
  MotionModel motion_;
};

TEST_F(KeyframeChainTest, TheNextOneFollowsTheLast) {
  EXPECT_FALSE(MakeAt(1).previous.valid());
  const Keyframe second = MakeAt(3);
  EXPECT_EQ(second.previous, KeyframeId{1});
  ASSERT_TRUE(second.dr);
  EXPECT_NEAR(second.dr->T_BaBb.translation().x(), 2, 1e-9);
  EXPECT_FALSE(second.withdraws);
}

TEST_F(KeyframeChainTest, WhatIsVoidIsWithdrawnByTheNextWhichIsDueAtOnce) {
  for (const double s : {1.0, 2.0, 3.0, 4.0}) MakeAt(s);
  EXPECT_FALSE(Due());
  EXPECT_EQ(chain_.Void(Second(2.5)), KeyframeId{2});
  EXPECT_TRUE(Due());
  const Keyframe next = MakeAt(5);
  EXPECT_EQ(next.id, KeyframeId{5});
  EXPECT_EQ(next.previous, KeyframeId{2});
  EXPECT_TRUE(next.withdraws);
  ASSERT_TRUE(next.dr);
  EXPECT_NEAR(next.dr->T_BaBb.translation().x(), 3, 1e-9);
  EXPECT_FALSE(Due());
  const Keyframe after = MakeAt(6);
  EXPECT_EQ(after.previous, KeyframeId{5});
  EXPECT_FALSE(after.withdraws);
}

TEST_F(KeyframeChainTest, TheFirstOfAChainStays) {
  MakeAt(1);
  MakeAt(2);
  EXPECT_EQ(chain_.Void(Second(0.5)), KeyframeId{1});
  EXPECT_TRUE(MakeAt(3).withdraws);
}

TEST_F(KeyframeChainTest, NothingIsVoidThatWasNotMadeSince) {
  MakeAt(1);
  MakeAt(2);
  EXPECT_EQ(chain_.Void(Second(2.5)), KeyframeId{2});
  EXPECT_FALSE(Due());
  EXPECT_FALSE(MakeAt(3).withdraws);
  chain_.Break();
  EXPECT_FALSE(chain_.Void(Second(0)).valid());
  const Keyframe alone = MakeAt(4);
  EXPECT_FALSE(alone.previous.valid());
  EXPECT_FALSE(alone.withdraws);
}

}  // namespace
}  // namespace gw::frontend

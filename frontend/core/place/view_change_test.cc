#include "frontend/core/place/view_change.h"

#include <gtest/gtest.h>

#include "frontend/core/features/test_camera.h"
#include "frontend/core/place/test_view.h"

namespace gw::frontend {
namespace {

const SE3 kStart;
const SE3 kTurned(ExpSO3({0, 0.15, 0}), {0.02, 0, 0.1});

class ViewChanges : public testing::Test {
 protected:
  ViewChanges() : view_(TestCamera(6)) {
    EXPECT_EQ(Observe(SeeScene(1, kStart, 1), kStart), ViewVerdict::kUnknown);
  }
  ViewVerdict Observe(const FeatureFrame& frame, const std::optional<SE3>& T_OC) {
    const ViewVerdict verdict = view_.Compare(frame, T_OC);
    view_.Remember(frame, T_OC);
    return verdict;
  }

 private:
  ViewChange view_;
};

TEST_F(ViewChanges, NotWhileTheRobotMovesThroughTheScene) {
  EXPECT_EQ(Observe(SeeScene(1, kTurned, 2), kTurned), ViewVerdict::kSame);
}

TEST_F(ViewChanges, WhenTheRobotIsElsewhereAtOnce) {
  EXPECT_EQ(Observe(SeeScene(2, kStart, 2), kTurned), ViewVerdict::kOther);
  // The new scene stays.
  EXPECT_EQ(Observe(SeeScene(2, kStart, 3), kTurned), ViewVerdict::kSame);
}

TEST_F(ViewChanges, WhenTheImageTurnsWithoutTheWheels) {
  const SE3 turned(ExpSO3({0, 0.6, 0}), {0, 0, 0});
  EXPECT_EQ(Observe(SeeScene(1, turned, 2), kStart), ViewVerdict::kOther);
}

TEST_F(ViewChanges, IsNotSaidOfPoorImages) {
  EXPECT_EQ(Observe(SeeScene(2, kStart, 2, 400), kStart), ViewVerdict::kUnknown);
  // Nor of the first after them.
  EXPECT_EQ(Observe(SeeScene(3, kStart, 3), kStart), ViewVerdict::kUnknown);
}

// As between images that a slow camera takes while the robot drives.
TEST_F(ViewChanges, AlsoAcrossAWayOnWhichTheViewStaysInSight) {
  const SE3 far(Eigen::Quaterniond::Identity(), {0, 0, 0.5});
  EXPECT_EQ(Observe(SeeScene(1, far, 2), far), ViewVerdict::kSame);
  const SE3 farther(ExpSO3({0, 0.15, 0}), {0.1, 0, 0.9});
  EXPECT_EQ(Observe(SeeScene(2, farther, 3), farther), ViewVerdict::kOther);
}

TEST_F(ViewChanges, IsNotSaidWhereTheImagesHaveLittleInCommon) {
  const SE3 turned(ExpSO3({0, 1.0, 0}), {0, 0, 0});
  EXPECT_EQ(Observe(SeeScene(2, turned, 2), turned), ViewVerdict::kUnknown);
}

// Where they are in the image, their depth decides: they are not expected anywhere.
TEST_F(ViewChanges, FeaturesWithoutDepthSayNothingAcrossAWay) {
  FeatureFrame before = SeeScene(1, kStart, 1);
  for (Feature& f : before.features) f.depth = 0;
  const SE3 beside(Eigen::Quaterniond::Identity(), {0.6, 0, 0});
  EXPECT_EQ(
      CountSeenAgain(TestCamera(6), before, SeeScene(1, beside, 2), beside.inverse()).expected, 0);
  EXPECT_GT(CountSeenAgain(TestCamera(6), before, SeeScene(1, kStart, 2), SE3()).share(), 0.2);
}

TEST_F(ViewChanges, IsNotSaidWithoutDeadReckoning) {
  EXPECT_EQ(Observe(SeeScene(2, kStart, 2), std::nullopt), ViewVerdict::kUnknown);
  EXPECT_EQ(Observe(SeeScene(3, kStart, 3), kStart), ViewVerdict::kUnknown);
}

}  // namespace
}  // namespace gw::frontend

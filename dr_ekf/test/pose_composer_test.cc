#include "dr_ekf/core/pose_composer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gw::dr_ekf {
namespace {

// Drives straight along x of O at 1 m/s.
DrState StateAt(int ms, uint32_t counter = 0, const SE3& T_OB_begin = SE3()) {
  DrState s;
  s.utime = {ms * 1000};
  s.seq = ms;
  s.reset_counter = counter;
  s.T_OB = T_OB_begin * SE3(Eigen::Quaterniond::Identity(), {1e-3 * ms, 0, 0});
  s.v_OB_B = {1, 0, 0};
  s.cov_twist_white = Matrix6d::Identity() * 1e-4;
  s.cov_twist_coherent(0, 0) = 4e-4;  // 2 % of the speed
  return s;
}

FramePose FrameAt(int ms, const SE3& T_WB, TrackingStatus status = TrackingStatus::kTracking) {
  FramePose f;
  f.utime = {ms * 1000};
  f.seq = ms;
  f.status = status;
  f.T_WB = T_WB;
  f.cov_T_WB = Matrix6d::Identity() * 1e-6;
  return f;
}

SE3 Somewhere(double x, double yaw = 0.5) {
  return SE3(Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {x, 2, 0});
}

double Distance(const SE3& a, const SE3& b) {
  return (a.inverse() * b).Log().norm();
}

TEST(PoseComposer, WorldIsTheOdometryFrameUntilTheFirstFrame) {
  PoseComposer composer;
  const std::optional<Pose> pose = composer.Push(StateAt(10));
  ASSERT_TRUE(pose);
  EXPECT_FALSE(pose->has_map);
  EXPECT_LT(Distance(pose->T_WB, StateAt(10).T_OB), 1e-12);
}

TEST(PoseComposer, LatchesTheFrameAtTheTimeOfItsImage) {
  PoseComposer composer;
  for (int ms = 0; ms <= 200; ms += 10) composer.Push(StateAt(ms));
  ASSERT_EQ(composer.Push(FrameAt(100, Somewhere(3))), LatchResult::kLatched);
  const std::optional<Pose> pose = composer.Push(StateAt(210));
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->has_map);
  EXPECT_EQ(pose->frame_pose_age_us, 110000);
  const SE3 expected = Somewhere(3) * SE3(Eigen::Quaterniond::Identity(), {0.11, 0, 0});
  EXPECT_LT(Distance(pose->T_WB, expected), 1e-9);
  EXPECT_LT(Distance(pose->T_WO * StateAt(210).T_OB, pose->T_WB), 1e-12);
}

TEST(PoseComposer, IgnoresFramesWithoutAPose) {
  for (const TrackingStatus status :
       {TrackingStatus::kInvalid, TrackingStatus::kInitializing, TrackingStatus::kLost}) {
    PoseComposer composer;
    composer.Push(StateAt(0));
    composer.Push(StateAt(100));
    ASSERT_EQ(composer.Push(FrameAt(50, Somewhere(3))), LatchResult::kLatched);
    EXPECT_EQ(composer.Push(FrameAt(90, Somewhere(9), status)), LatchResult::kIgnoredStatus);
    EXPECT_EQ(composer.Push(StateAt(110))->frame_pose_seq, 50);
  }
}

TEST(PoseComposer, TakesItsClaimBackWhenThePlaceIsInDoubt) {
  PoseComposer composer;
  for (int ms = 0; ms <= 100; ms += 10) composer.Push(StateAt(ms));
  composer.Push(FrameAt(50, Somewhere(3)));
  FramePose doubt = FrameAt(90, Somewhere(3.04), TrackingStatus::kRecovering);
  doubt.reason = TrackingReason::kPoseJump;
  doubt.cov_T_WB = Matrix6d::Identity() * 100;
  EXPECT_EQ(composer.Push(doubt), LatchResult::kLatched);
  EXPECT_GT(composer.Push(StateAt(110))->cov_T_WB(0, 0), 99);
  // Found again.
  EXPECT_EQ(composer.Push(FrameAt(105, Somewhere(9), TrackingStatus::kRecovering)),
            LatchResult::kLatched);
  EXPECT_LT(composer.Push(StateAt(120))->cov_T_WB(0, 0), 0.01);
}

TEST(PoseComposer, KnowsBetterThanAFrontEndThatBegins) {
  FramePose begins = FrameAt(90, Somewhere(0), TrackingStatus::kRecovering);
  begins.reason = TrackingReason::kPlaceUnknown;
  begins.cov_T_WB = Matrix6d::Identity() * 100;
  PoseComposer composer;
  for (int ms = 0; ms <= 100; ms += 10) composer.Push(StateAt(ms));
  EXPECT_EQ(composer.Push(begins), LatchResult::kIgnoredStatus);
  EXPECT_FALSE(composer.Push(StateAt(110))->has_map);
  composer.Push(FrameAt(50, Somewhere(3)));
  EXPECT_EQ(composer.Push(begins), LatchResult::kIgnoredStatus);
  EXPECT_EQ(composer.Push(StateAt(120))->frame_pose_seq, 50);
}

TEST(PoseComposer, FollowsAMapThatMovesWhileVisionIsGone) {
  PoseComposer composer;
  composer.Push(StateAt(0));
  composer.Push(StateAt(100));
  composer.Push(FrameAt(50, Somewhere(3)));
  FramePose blind = FrameAt(90, Somewhere(4), TrackingStatus::kDrOnly);
  blind.map_revision = 7;
  EXPECT_EQ(composer.Push(blind), LatchResult::kLatched);
  EXPECT_EQ(composer.Push(StateAt(110))->map_revision, 7);
}

// The front-end knows by vision that dead reckoning tells 2 % of the way too much.
TEST(PoseComposer, FollowsTheCalibratedDeadReckoningOfTheFrontEndWhileVisionIsGone) {
  PoseComposer composer;
  composer.Push(StateAt(0));
  ASSERT_EQ(composer.Push(FrameAt(0, Somewhere(3))), LatchResult::kLatched);
  std::optional<Pose> pose;
  const auto moved = [](double way) { return SE3(Eigen::Quaterniond::Identity(), {way, 0, 0}); };
  for (int ms = 10; ms <= 10000; ms += 10) {
    pose = composer.Push(StateAt(ms));
    if (ms % 50 != 0 || ms > 9900) continue;
    const SE3 T_WB = Somewhere(3) * moved(0.98e-3 * ms);
    ASSERT_EQ(composer.Push(FrameAt(ms, T_WB, TrackingStatus::kDrOnly)), LatchResult::kLatched);
  }
  const SE3 expected = Somewhere(3) * moved(0.98 * 9.9 + 0.1);
  EXPECT_LT(Distance(pose->T_WB, expected), 1e-9);
  EXPECT_EQ(pose->frame_pose_age_us, 100000);
}

TEST(PoseComposer, RefusesStaleUncoveredAndInvalidFrames) {
  PoseComposer composer;
  EXPECT_EQ(composer.Push(FrameAt(0, Somewhere(1))), LatchResult::kNoDeadReckoning);
  composer.Push(StateAt(100));
  composer.Push(StateAt(200));
  EXPECT_EQ(composer.Push(FrameAt(50, Somewhere(1))), LatchResult::kNoDeadReckoning);
  EXPECT_EQ(composer.Push(FrameAt(701, Somewhere(1))), LatchResult::kNoDeadReckoning);
  EXPECT_EQ(composer.Push(FrameAt(150, Somewhere(1))), LatchResult::kLatched);
  EXPECT_EQ(composer.Push(FrameAt(150, Somewhere(1))), LatchResult::kStale);
  FramePose bad = FrameAt(190, Somewhere(1));
  bad.cov_T_WB(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(composer.Push(bad), LatchResult::kInvalid);
  EXPECT_FALSE(composer.Push(StateAt(200)));
}

TEST(PoseComposer, CovarianceGrowsFromThatOfTheFrame) {
  PoseComposer composer;
  for (int ms = 0; ms <= 100; ms += 10) composer.Push(StateAt(ms));
  composer.Push(FrameAt(100, Somewhere(3)));
  double before = 1e-6;
  std::optional<Pose> pose;
  for (int ms = 110; ms <= 60100; ms += 10) {
    pose = composer.Push(StateAt(ms));
    EXPECT_GT(pose->cov_T_WB(0, 0), before);
    before = pose->cov_T_WB(0, 0);
  }
  // One minute, 60 m: 2 % of the way, coherently, also past the window of any history.
  EXPECT_NEAR(std::sqrt(pose->cov_T_WB(0, 0)), 0.02 * 60, 0.01);
}

TEST(PoseComposer, PoseStaysContinuousAcrossAReset) {
  PoseComposer composer;
  for (int ms = 0; ms <= 100; ms += 10) composer.Push(StateAt(ms));
  composer.Push(FrameAt(100, Somewhere(3)));
  const std::optional<Pose> before = composer.Push(StateAt(110));
  const std::optional<Pose> after = composer.Push(StateAt(120, 1, Somewhere(-20, 2.0)));
  ASSERT_TRUE(after);
  EXPECT_LT(Distance(before->T_WB, after->T_WB), 1e-9);
  EXPECT_GT(after->cov_T_WB(0, 0), before->cov_T_WB(0, 0) + 0.009);
  // An image from before the reset cannot be used, one after it can.
  EXPECT_EQ(composer.Push(FrameAt(110, Somewhere(4))), LatchResult::kNoDeadReckoning);
  EXPECT_EQ(composer.Push(FrameAt(120, Somewhere(4))), LatchResult::kLatched);
}

TEST(PoseComposer, GoesOnAfterTheClockWasSetBack) {
  PoseComposer composer;
  composer.Push(StateAt(5000));
  EXPECT_TRUE(composer.Push(StateAt(100, 1)));
  EXPECT_TRUE(composer.Push(StateAt(110, 1)));
}

}  // namespace
}  // namespace gw::dr_ekf

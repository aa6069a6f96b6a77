// The tracker in a synthetic room. GIVEN what the camera and the wheels see, the claims are about
// poses.
#include "frontend/core/tracking/tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "frontend/core/tracking/tracker_test_room.h"

namespace gw::frontend {
namespace {

TEST(Tracker, FollowsThePathByVisionAlone) {
  const Recording run = Drive(Variant::kNone, 300, 0, 0, 0);
  for (size_t i = 0; i < run.poses.size(); ++i) {
    EXPECT_EQ(run.poses[i].status, TrackingStatus::kTracking) << i;
    EXPECT_LT(run.errors_m[i], 0.03) << i;
  }
  EXPECT_GT(run.keyframes.size(), 5u);
}

TEST(Tracker, VisionOnlyLosesThePoseInTheDarkAndFindsItAgain) {
  const Recording run = Drive(Variant::kNone, 300, 100, 160, 0);
  EXPECT_EQ(run.poses[150].status, TrackingStatus::kLost);
  // Two seconds turn the robot by 60 degrees: the old view is gone, and only a return would help.
  for (const FramePose& pose : run.poses) EXPECT_TRUE(pose.T_WB.IsFinite());
}

TEST(Tracker, DeadReckoningCarriesThePoseThroughTheDark) {
  const Recording run = Drive(Variant::kFull, 300, 100, 160, 1.02);
  EXPECT_EQ(run.poses[150].status, TrackingStatus::kDrOnly);
  EXPECT_EQ(run.poses[150].alpha, DrWeightConfig{}.alpha_max);
  for (size_t i = 0; i < run.poses.size(); ++i) EXPECT_LT(run.errors_m[i], 0.06) << i;
  EXPECT_EQ(run.poses.back().status, TrackingStatus::kTracking);
}

// This source of dead reckoning says nothing of its noise, so that its nominal noise is the bound:
// alpha below 1 stands, alpha above 1 has no effect (docs/method.md, section 3.3).
TEST(Tracker, ReportsThePriorByTheLawAndAfterItsBound) {
  const Recording run = Drive(Variant::kFull, 160, 100, 160, 1.0);
  for (size_t i = 1; i < run.details.size(); ++i) {
    const FrameDetail& prior = run.details[i];
    EXPECT_EQ(prior.utime, run.poses[i].utime);
    EXPECT_EQ(prior.seq, run.poses[i].seq);
    EXPECT_EQ(prior.q, run.poses[i].q) << i;
    EXPECT_LE(prior.q_close, prior.q) << i;
    EXPECT_EQ(prior.alpha_rotation, run.poses[i].alpha) << i;
    EXPECT_NEAR(prior.bounded_rotation, std::min(prior.alpha_rotation, 1.0), 1e-6) << i;
    EXPECT_NEAR(prior.bounded_translation, std::min(prior.alpha_translation, 1.0), 1e-6) << i;
  }
  EXPECT_LT(run.details[50].alpha_rotation, 1);
  EXPECT_GT(run.details[50].alpha_rotation, 0);
  EXPECT_EQ(run.details[150].alpha_translation, DrWeightConfig{}.alpha_max);
  for (const FrameDetail& prior : Drive(Variant::kDa, 20, 0, 0, 1.0).details) {
    EXPECT_EQ(prior.alpha_rotation, 0);
    EXPECT_EQ(prior.bounded_rotation, 0);
  }
}

// Equation 6 of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, has no least number of matches.
TEST(Tracker, ThePapersPoseTakesAnyNumberOfMatches) {
  FrontendConfig paper;
  paper.dr_weight.method = Method::kPaper;
  const Recording run = Drive(paper, 300, 100, 110, 1.0, 1, 5);
  for (int i = 101; i < 110; ++i) {
    EXPECT_EQ(run.poses[i].status, TrackingStatus::kDegraded) << i;
    EXPECT_GT(run.poses[i].num_inliers, 0) << i;
    EXPECT_LE(run.poses[i].num_inliers, 5) << i;
    EXPECT_GT(run.poses[i].dr_share, 0.5) << i;
  }
  for (size_t i = 0; i < run.poses.size(); ++i) EXPECT_LT(run.errors_m[i], 0.03) << i;
  const Recording ours = Drive(FrontendConfig(), 300, 100, 110, 1.0, 1, 5);
  EXPECT_EQ(ours.poses[105].status, TrackingStatus::kDrOnly);
}

TEST(Tracker, ABudgetOfMatchesIsKeptAndTheMapIsNotMadeTwice) {
  FrontendConfig config;
  config.variant = Variant::kNone;
  const Recording all = Drive(config, 300, 0, 0, 0);
  config.matching_budget = 100;
  for (const Matching matching : {Matching::kGood, Matching::kRandom}) {
    config.matching = matching;
    const Recording run = Drive(config, 300, 0, 0, 0);
    SCOPED_TRACE(matching == Matching::kGood ? "good" : "random");
    for (size_t i = 0; i < run.poses.size(); ++i) {
      EXPECT_EQ(run.poses[i].status, TrackingStatus::kTracking) << i;
      EXPECT_LE(run.poses[i].num_inliers, 100) << i;
      EXPECT_LT(run.errors_m[i], 0.06) << i;
    }
    const auto landmarks_made = [](const Recording& r) {
      int made = 0;
      for (const Keyframe& k : r.keyframes) {
        for (const LandmarkId id : k.landmarks) made += id.valid() && id.creator() == k.id;
      }
      return made;
    };
    // Good ones are near, and leave the view sooner.
    EXPECT_LT(run.keyframes.size(), 2.5 * static_cast<double>(all.keyframes.size()));
    EXPECT_LT(landmarks_made(run), 1.3 * landmarks_made(all));
  }
}

// What is mapped after the dark is no surer of where the map begins than dead reckoning was.
TEST(Tracker, CovarianceGrowsWhileBlindAndStaysOnNewGround) {
  const Recording run = Drive(Variant::kFull, 300, 100, 160, 1.0);
  double last = 0;
  for (int i = 101; i < 160; ++i) {
    const double trace = run.poses[i].cov_T_WB.diagonal().head<3>().sum();
    EXPECT_GT(trace, last);
    last = trace;
  }
  const auto trace = [&](size_t i) { return run.poses[i].cov_T_WB.diagonal().head<3>().sum(); };
  EXPECT_EQ(run.poses[299].status, TrackingStatus::kTracking);
  EXPECT_GT(trace(299), 0.5 * last);
  EXPECT_LT(trace(99), 0.1 * last);
}

// Poses a second apart share their drift: the motion between them is known better than two
// independent poses would say.
TEST(Tracker, TellsTheCovarianceOfItsMotion) {
  const Recording run = Drive(Variant::kFull, 200, 100, 160, 1.0);
  EXPECT_EQ(run.poses[20].motion_us, 0);
  for (size_t i = 32; i < run.poses.size(); ++i) {
    const FramePose& b = run.poses[i];
    ASSERT_EQ(b.motion_us, 30 * kFrameUs) << i;
    EXPECT_GT(b.cov_motion.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0) << i;
    const FramePose& a = run.poses[i - 30];
    const Matrix6d adj = (b.T_WB.inverse() * a.T_WB).Adjoint();
    const Matrix6d independent = b.cov_T_WB + adj * a.cov_T_WB * adj.transpose();
    EXPECT_LE(b.cov_motion.trace(), independent.trace() * (1 + 1e-9)) << i;
  }
}

TEST(Tracker, BlindPoseIsExactlyTheDeadReckoning) {
  const Recording run = Drive(Variant::kFull, 200, 100, 160, 1.02);
  const SE3 vision = run.poses[99].T_WB.inverse() * run.poses[159].T_WB;
  SE3 dr;
  for (int i = 100; i <= 159; ++i) {
    const SE3 step = TruePose((i - 1) * kFrameUs * 1e-6).inverse() * TruePose(i * kFrameUs * 1e-6);
    dr = dr * SE3(step.rotation(), 1.02 * step.translation());
  }
  EXPECT_LT((vision.inverse() * dr).Log().norm(), 1e-9);
}

// A clock that is set back costs a few images, not the map.
TEST(Tracker, GoesOnInTheSameMapWhenTheClockIsSetBack) {
  const World world;
  for (const bool with_dr : {false, true}) {
    Tracker tracker = *Tracker::Create({}, world.geometry());
    MapUpdate empty;
    empty.snapshot = true;
    EXPECT_TRUE(tracker.Push(empty));
    constexpr int kSet = 100;
    int refused = 0;
    for (int i = 0; i < 200; ++i) {
      const SE3 T_WB = TruePose(i * kFrameUs * 1e-6);
      const Utime utime{20'000'000 + i * kFrameUs - (i >= kSet ? 10'000'000 : 0)};
      DrState s;
      s.utime = utime;
      s.seq = i + 1;
      s.reset_counter = i >= kSet ? 1 : 0;
      s.T_OB = T_WB;
      if (with_dr) {
        EXPECT_TRUE(tracker.Push(s));
      }
      const FramePose pose = tracker.Track(utime, i + 1, world.See(T_WB, i, false)).pose;
      if (pose.reason == TrackingReason::kTimeReversed) {
        ++refused;
        EXPECT_LT(i, kSet + 3);
      } else if (i >= kSet + 6) {
        EXPECT_EQ(pose.status, TrackingStatus::kTracking) << i;
        EXPECT_LT((pose.T_WB.translation() - T_WB.translation()).norm(), 0.03) << i;
      }
    }
    EXPECT_EQ(refused, 2);
  }
}

TEST(Tracker, EveryImageGetsAPoseEvenBadOnes) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  CameraFrame empty;
  empty.utime = {1000};
  EXPECT_EQ(tracker.Push(empty).pose.reason, TrackingReason::kBadImage);
  const uint8_t pixels[16] = {};
  CameraFrame small;
  small.utime = {34000};
  small.left = small.depth = {pixels, 4, 4, 4, PixelFormat::kGray8};
  EXPECT_EQ(tracker.Push(small).pose.reason, TrackingReason::kBadImage);
  small.utime = {33000};
  EXPECT_EQ(tracker.Push(small).pose.reason, TrackingReason::kTimeReversed);
}

TEST(Tracker, WaitsForTheMapBeforeItBeginsOne) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  const auto out = tracker.Track({0}, 1, world.See(SE3(), 0, false));
  EXPECT_EQ(out.pose.status, TrackingStatus::kInitializing);
  EXPECT_FALSE(out.keyframe);
  MapUpdate taken;
  taken.snapshot = true;
  taken.newest_keyframe = {41};
  EXPECT_TRUE(tracker.Push(taken));
  const auto next = tracker.Track({kFrameUs}, 2, world.See(SE3(), 1, false));
  ASSERT_TRUE(next.keyframe);
  EXPECT_EQ(next.keyframe->id.value, 42);
}

TEST(Tracker, MakesNoKeyframeOfAFrozenMap) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  MapUpdate frozen;
  frozen.snapshot = frozen.frozen = true;
  EXPECT_TRUE(tracker.Push(frozen));
  EXPECT_FALSE(tracker.Track({0}, 1, world.See(SE3(), 0, false)).keyframe);
  frozen.frozen = false;
  EXPECT_TRUE(tracker.Push(frozen));
  EXPECT_TRUE(tracker.Track({kFrameUs}, 2, world.See(SE3(), 1, false)).keyframe);
}

TEST(Tracker, RefusesAMapUpdateWithAGap) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  MapUpdate update;
  update.snapshot = true;
  update.revision = 5;
  EXPECT_TRUE(tracker.Push(update));
  update.snapshot = false;
  update.base_revision = 6;
  update.revision = 7;
  EXPECT_FALSE(tracker.Push(update));
  update.base_revision = 5;
  update.revision = 6;
  EXPECT_TRUE(tracker.Push(update));
}

}  // namespace
}  // namespace gw::frontend

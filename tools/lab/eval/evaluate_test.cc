#include "tools/lab/eval/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tools/lab/eval/test_trajectories.h"

namespace gw::eval {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

EvalOptions Unaligned() {
  EvalOptions options;
  options.alignment = Alignment::kNone;
  return options;
}

TEST(Summarise, ByHand) {
  const Stats odd = Summarise({3, 0, 6});
  EXPECT_EQ(odd.count, 3);
  EXPECT_DOUBLE_EQ(odd.rmse, std::sqrt(15.0));
  EXPECT_DOUBLE_EQ(odd.mean, 3);
  EXPECT_DOUBLE_EQ(odd.median, 3);
  EXPECT_DOUBLE_EQ(odd.max, 6);
  EXPECT_DOUBLE_EQ(Summarise({4, 1, 2, 9}).median, 3);
  EXPECT_EQ(Summarise({}).count, 0);
}

TEST(Evaluate, RigidlyMovedTrajectoryHasNoError) {
  const Trajectory ref = Eight(300, 0.1);
  for (int i = 0; i < 200; ++i) {
    CounterRng rng(1, 0, i);
    const auto e = Evaluate(ref, Moved(RandomPose(rng), ref), EvalOptions{});
    ASSERT_TRUE(e.ok());
    EXPECT_LT(e->ape_translation_m.max, 1e-12) << "case " << i;
    EXPECT_LT(e->ape_rotation_deg.max, 1e-12 * 180) << "case " << i;
    EXPECT_LT(e->rpe_translation_m.max, 1e-12) << "case " << i;
    EXPECT_LT(e->drift.final_error_m, 1e-12) << "case " << i;
    EXPECT_EQ(e->completeness, 1.0);
  }
}

// The reference drives 1 m/s along x; the estimate believes 1.1 m/s: 0.1 m more every second.
TEST(Evaluate, ScaleErrorOnAStraightLineByHand) {
  Trajectory ref;
  Trajectory est;
  for (int i = 0; i <= 10; ++i) {
    ref.push_back(At(i, i, 0));
    est.push_back(At(i, 1.1 * i, 0));
  }
  const auto e = Evaluate(ref, est, Unaligned());
  ASSERT_TRUE(e.ok()) << e.error().message;
  EXPECT_NEAR(e->ape_translation_m.rmse, std::sqrt(385.0 / 11.0) * 0.1, 1e-12);
  EXPECT_NEAR(e->ape_translation_m.mean, 0.5, 1e-12);
  EXPECT_NEAR(e->ape_translation_m.median, 0.5, 1e-12);
  EXPECT_NEAR(e->ape_translation_m.max, 1.0, 1e-12);
  EXPECT_EQ(e->rpe_translation_m.count, 10);
  EXPECT_NEAR(e->rpe_translation_m.rmse, 0.1, 1e-12);
  EXPECT_NEAR(e->drift.path_length_m, 10, 1e-12);
  EXPECT_NEAR(e->drift.final_error_m, 1, 1e-12);
  EXPECT_NEAR(*e->drift.final_percent, 10, 1e-10);
  EXPECT_EQ(e->drift.segments, 10 + 9 + 6 + 1);  // of 1, 2, 5 and 10 m
  EXPECT_NEAR(*e->drift.segment_percent, 10, 1e-10);
  EXPECT_NEAR(*e->drift.segment_deg_per_m, 0, 1e-12);
}

// Driving straight for 1 m while believing to turn by 9 degrees a second.
TEST(Evaluate, RotationErrorByHand) {
  Trajectory ref;
  Trajectory est;
  for (int i = 0; i <= 4; ++i) {
    ref.push_back(At(i, 0.25 * i, 0));
    est.push_back(ref.back());
    est.back().T = SE3(ExpSO3({0, 0, 9 * i * std::numbers::pi / 180}), est.back().T.translation());
  }
  const auto e = Evaluate(ref, est, Unaligned());
  ASSERT_TRUE(e.ok());
  EXPECT_NEAR(e->ape_translation_m.max, 0, 1e-15);
  EXPECT_NEAR(e->ape_rotation_deg.mean, 18, 1e-12);
  EXPECT_NEAR(e->ape_rotation_deg.max, 36, 1e-12);
  EXPECT_NEAR(e->rpe_rotation_deg.rmse, 9, 1e-12);
  // Seen from a body that believes to look i * 9 deg to the left, the step ahead points elsewhere:
  // its error is the chord 2 * 0.25 * sin(i * 4.5 deg).
  double mean = 0;
  for (int i = 0; i < 4; ++i) mean += 0.5 * std::sin(i * 4.5 * std::numbers::pi / 180) / 4;
  EXPECT_NEAR(e->rpe_translation_m.mean, mean, 1e-12);
  EXPECT_NEAR(e->drift.final_error_deg, 36, 1e-12);
  EXPECT_NEAR(*e->drift.segment_deg_per_m, 36, 1e-10);  // one segment of 1 m
}

TEST(Evaluate, RpeUsesOnlyPairsThatFarApart) {
  const Trajectory t = {At(0, 0, 0), At(0.5, 1, 0), At(1.08, 2, 0), At(1.7, 3, 0), At(3, 4, 0)};
  const auto e = Evaluate(t, t, Unaligned());
  ASSERT_TRUE(e.ok());
  EXPECT_EQ(e->rpe_translation_m.count, 1);  // 0 to 1.08; all others miss 1 s by over 0.1 s
}

TEST(Evaluate, ReferenceAtRestHasNoWay) {
  Trajectory ref;
  for (int i = 0; i < 1000; ++i) {
    CounterRng rng(5, 0, i);
    ref.push_back(At(0.01 * i, 0.001 * rng.Normal(), 0.001 * rng.Normal()));
  }
  const auto e = Evaluate(ref, ref, Unaligned());
  ASSERT_TRUE(e.ok());
  EXPECT_EQ(e->drift.path_length_m, 0);
  EXPECT_FALSE(e->drift.final_percent.has_value());
  EXPECT_FALSE(e->drift.segment_percent.has_value());
}

TEST(Evaluate, GapsAreWhatTheEstimateLeavesOpen) {
  Trajectory ref;
  for (int i = 0; i <= 100; ++i) ref.push_back(At(0.1 * i, 0.1 * i, 0));
  Trajectory est;
  for (const TimedPose& pose : ref) {
    const double t = pose.utime.seconds();
    if (t >= 1 && t < 9 && !(t > 3 && t < 5)) est.push_back(pose);
  }
  EXPECT_THAT(Gaps(ref, est), ElementsAre(Pair(0, 1), Pair(3, 5), Pair(8.9, 10)));
  EXPECT_NEAR(Completeness(ref, est), 0.59, 1e-12);
  EXPECT_EQ(Completeness(ref, ref), 1.0);
  EXPECT_EQ(Completeness(ref, {ref[0]}), 0.0);
  EXPECT_EQ(Completeness(ref, {At(20, 0, 0), At(21, 0, 0)}), 0.0);
}

TEST(Evaluate, CoverageCountsImagesWithAPose) {
  const Trajectory est = {At(0.1, 0, 0), At(0.2, 0, 0)};
  EXPECT_DOUBLE_EQ(Coverage({{100000}, {200001}, {300000}, {100003}}, est), 0.5);
}

TEST(Evaluate, RefusesWhatCannotBeCompared) {
  const Trajectory t = Eight(10, 0.1);
  Trajectory later = t;
  for (TimedPose& pose : later) pose.utime = pose.utime + Milliseconds(100000);
  const auto message = [](const Trajectory& ref, const Trajectory& est) {
    return Evaluate(ref, est, EvalOptions{}).error().message;
  };
  EXPECT_THAT(message({}, t), HasSubstr("the reference holds no pose"));
  EXPECT_THAT(message(t, {}), HasSubstr("the estimate holds no pose"));
  EXPECT_THAT(message(t, later), HasSubstr("reference 0 to 900000, estimate 100000000 to "));
  EXPECT_THAT(message(t, {t[3]}), HasSubstr("only one pose"));
}

TEST(Evaluate, OnePoseWithoutAlignmentHasAnAbsoluteErrorOnly) {
  const auto e = Evaluate({At(1, 0, 0)}, {At(1, 3, 4)}, Unaligned());
  ASSERT_TRUE(e.ok());
  EXPECT_DOUBLE_EQ(e->ape_translation_m.rmse, 5);
  EXPECT_EQ(e->rpe_translation_m.count, 0);
  EXPECT_FALSE(e->drift.final_percent.has_value());
}

}  // namespace
}  // namespace gw::eval

#include "tools/lab/study/trials.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gw::study {
namespace {

SE3 At(double x, double y, double yaw_deg = 0) {
  return SE3(ExpSO3({0, 0, yaw_deg * M_PI / 180}), {x, y, 0});
}

// 100 s along x at 0.5 m/s, 10 poses a second.
eval::Trajectory Straight() {
  eval::Trajectory out;
  for (int i = 0; i <= 1000; ++i) out.push_back({UtimeFromSeconds(0.1 * i), At(0.05 * i, 0)});
  return out;
}

// Keyframes along the first 20 m (40 s).
MappedViews FirstPart() {
  std::vector<SE3> views;
  for (int i = 0; i <= 40; ++i) views.push_back(At(0.5 * i, 0));
  return MappedViews(std::move(views));
}

TrialPlan Plan() {
  TrialPlan plan;
  plan.starts = 30;
  plan.carries = 20;
  plan.length = Milliseconds(20000);
  return plan;
}

FramePose Frame(double sigma_m, int inliers) {
  FramePose f;
  f.cov_T_WB = Matrix6d::Identity() * 1e-6;
  f.cov_T_WB(1, 1) = sigma_m * sigma_m;
  f.num_inliers = inliers;
  return f;
}

TEST(MappedViews, NearAndInTheSameDirection) {
  const MappedViews views({At(1, 1, 170)});
  EXPECT_TRUE(views.InSight(At(1.7, 1.7, -165)));
  EXPECT_FALSE(views.InSight(At(1.8, 1.8, 170)));
  EXPECT_FALSE(views.InSight(At(1, 1, -155)));
  EXPECT_FALSE(MappedViews({}).InSight(At(1, 1, 170)));
}

TEST(DrawTrials, EachKindBeginsAndLandsWhereItShould) {
  const eval::Trajectory truth = Straight();
  const MappedViews views = FirstPart();
  int count[2][2] = {};
  Utime before;
  for (const Trial& trial : DrawTrials(truth, views, Plan())) {
    ++count[trial.carry.has_value() ? 1 : 0][trial.mapped ? 1 : 0];
    EXPECT_GE(trial.begin, before);
    before = trial.begin;
    const auto in_sight = [&](Utime at) { return views.InSight(At(0.5 * at.seconds(), 0)); };
    EXPECT_EQ(in_sight(trial.since()), trial.mapped);
    EXPECT_GE(trial.end - trial.since(), kShortestTrial);
    EXPECT_LE(trial.end - trial.since(), Plan().length);
    EXPECT_LE(trial.end, truth.back().utime);
    if (!trial.carry) continue;
    EXPECT_TRUE(in_sight(trial.begin));
    EXPECT_EQ(trial.carry->from - trial.begin, kBeforeCarry);
    EXPECT_GE((trial.carry->to - trial.carry->from).seconds(), 2 - 1e-9);  // 1 m at 0.5 m/s
  }
  EXPECT_EQ(count[0][0], 30);
  EXPECT_EQ(count[0][1], 30);
  EXPECT_EQ(count[1][0], 20);
  EXPECT_EQ(count[1][1], 20);
}

TEST(DrawTrials, TheSeedDecides) {
  const auto begins = [](uint64_t seed) {
    TrialPlan plan = Plan();
    plan.seed = seed;
    std::vector<int64_t> out;
    for (const Trial& trial : DrawTrials(Straight(), FirstPart(), plan)) {
      out.push_back(trial.begin.us);
    }
    return out;
  };
  EXPECT_EQ(begins(1), begins(1));
  EXPECT_NE(begins(1), begins(2));
}

TEST(DrawTrials, NothingIsDrawnInPlaceOfWhatTheLogDoesNotHave) {
  for (const Trial& trial : DrawTrials(Straight(), MappedViews({}), Plan())) {
    EXPECT_FALSE(trial.mapped);
    EXPECT_FALSE(trial.carry);
  }
  EXPECT_TRUE(DrawTrials({}, FirstPart(), Plan()).empty());
}

TEST(TrialJudge, LocalisedIsVisionThatClaimsAndIsRight) {
  const Trial trial{true, UtimeFromSeconds(10), UtimeFromSeconds(30), std::nullopt};
  TrialJudge judge(trial);
  const SE3 truth = At(5, 5);
  const auto see = [&](double at, const FramePose& frame, const SE3& T_GB, bool in_sight = true) {
    judge.See(UtimeFromSeconds(at), frame, T_GB, truth, in_sight);
  };
  see(10.0, Frame(10, 0), At(0, 0), false);  // claims nothing
  see(10.5, Frame(10, 0), At(0, 0));         // ... and a mapped view comes in sight
  see(11.0, Frame(0.01, 0), At(5, 5));       // dead reckoning
  see(11.1, Frame(0.11, 100), At(5, 5));     // does not claim
  see(11.2, Frame(0.01, 100), At(5.4, 5));   // neither right nor wrong
  see(11.3, Frame(0.01, 100), At(5, 5, 6));  // turned
  EXPECT_FALSE(judge.outcome().localised);
  EXPECT_EQ(judge.outcome().wrong, 0);
  see(11.5, Frame(0.01, 100), At(5.1, 5, 1));
  see(12.0, Frame(0.01, 100), At(5, 5));
  const TrialOutcome& o = judge.outcome();
  ASSERT_TRUE(o.localised);
  EXPECT_NEAR(o.localised->seconds(), 1.5, 1e-6);
  EXPECT_NEAR(o.Delay()->seconds(), 1.0, 1e-6);
  EXPECT_NEAR(o.error_m, 0.1, 1e-9);
  EXPECT_NEAR(o.error_deg, 1, 1e-9);
  EXPECT_NEAR(o.worst_claim_m, 0.4, 1e-9);
  EXPECT_EQ(o.images, 8);
  EXPECT_FALSE(judge.Over(UtimeFromSeconds(13.5)));
  EXPECT_TRUE(judge.Over(UtimeFromSeconds(13.6)));
}

TEST(TrialJudge, AWrongClaimCountsWhoeverMakesItAndWhenever) {
  const Trial trial{true, UtimeFromSeconds(10), UtimeFromSeconds(40),
                    Trial::Carry{UtimeFromSeconds(15), UtimeFromSeconds(20)}};
  TrialJudge judge(trial);
  judge.See(UtimeFromSeconds(11), Frame(0.01, 100), At(0, 0), At(0, 0.6), true);
  EXPECT_FALSE(judge.outcome().knew);
  judge.See(UtimeFromSeconds(14.9), Frame(0.01, 100), At(0, 0), At(0, 0), true);
  EXPECT_TRUE(judge.outcome().knew);
  EXPECT_FALSE(judge.outcome().localised) << "only what follows the carry tells";
  judge.See(UtimeFromSeconds(20.0), Frame(0.01, 0), At(0, 0), At(3, 0), true);  // not noticed yet
  judge.See(UtimeFromSeconds(20.1), Frame(5, 0), At(0, 0), At(3, 0), true);     // in doubt
  judge.See(UtimeFromSeconds(22.0), Frame(0.02, 90), At(3, 0), At(3, 0), true);
  EXPECT_TRUE(judge.outcome().knew);
  EXPECT_EQ(judge.outcome().wrong, 2);
  EXPECT_NEAR(judge.outcome().worst_claim_m, 3, 1e-9);
  EXPECT_NEAR(judge.outcome().localised->seconds(), 2, 1e-6);
}

}  // namespace
}  // namespace gw::study

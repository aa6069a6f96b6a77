#include "tools/lab/study/revisits.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gw::study {
namespace {

SE3 At(double x, double y, double yaw_deg) {
  return SE3(ExpSO3({0, 0, yaw_deg * M_PI / 180}), {x, y, 0});
}

// There and back along 20 m at 1 m/s, turning at the ends, and there again.
eval::Trajectory ThereBackAndThere() {
  eval::Trajectory out;
  for (int i = 0; i < 600; ++i) {
    const double t = 0.1 * i;
    const double x = t < 20 ? t : t < 40 ? 40 - t : t - 40;
    out.push_back({UtimeFromSeconds(1 + t), At(x, 0, t < 20 || t >= 40 ? 0 : 180)});
  }
  return out;
}

CovisiblePair Pair(double older_s, double newer_s, double distance_m = 0) {
  return {UtimeFromSeconds(older_s), UtimeFromSeconds(newer_s), distance_m};
}

TEST(FindRevisits, OnlyWhereTheRobotLooksTheSameWay) {
  const std::vector<Revisit> revisits = FindRevisits(ThereBackAndThere());
  ASSERT_EQ(revisits.size(), 1u);
  EXPECT_NEAR(revisits[0].begin.seconds(), 41, 0.3);
  EXPECT_NEAR(revisits[0].end.seconds(), 61, 0.3);
}

TEST(FindRevisits, WaitingIsNoRevisit) {
  eval::Trajectory waiting;
  for (int i = 0; i < 200; ++i) waiting.push_back({UtimeFromSeconds(0.1 * i), At(1, 1, 0)});
  EXPECT_TRUE(FindRevisits(waiting).empty());  // 20 s
  EXPECT_TRUE(FindRevisits({}).empty());
}

TEST(JudgeRevisits, ALoopIsClosedByAPairAcrossIt) {
  const std::vector<Revisit> revisits = {{UtimeFromSeconds(41), UtimeFromSeconds(61)},
                                         {UtimeFromSeconds(100), UtimeFromSeconds(110)}};
  const auto outcomes =
      JudgeRevisits(revisits, {Pair(1, 45), Pair(3, 43), Pair(40, 43), Pair(2, 80), Pair(99, 105)});
  ASSERT_EQ(outcomes.size(), 2u);
  EXPECT_EQ(outcomes[0].pairs, 2);
  EXPECT_EQ(outcomes[0].delay->us, 2'000'000);
  EXPECT_EQ(outcomes[1].pairs, 0);
  EXPECT_FALSE(outcomes[1].delay);
}

TEST(CountFalsePairs, ByTheTrueDistance) {
  EXPECT_EQ(CountFalsePairs({Pair(1, 50, 0.2), Pair(1, 50, 7.9), Pair(1, 50, 16)}), 1);
}

}  // namespace
}  // namespace gw::study

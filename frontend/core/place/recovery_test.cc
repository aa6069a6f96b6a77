#include "frontend/core/place/recovery.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

using Verdict = Recovery::Verdict;

const Matrix6d kSmall = Matrix6d::Identity() * 1e-4;
const SE3 kStep(Eigen::Quaterniond::Identity(), {0.02, 0, 0});

SE3 Pose(int i, double y = 0) {
  return SE3(Eigen::Quaterniond::Identity(), {0.02 * i, y, 0});
}

Recovery::Finding Found(int i, int num_inliers, double y = 0) {
  return {Pose(i, y), kSmall, num_inliers, kStep, kSmall};
}

Recovery::Expectation Expected(int i, bool in_doubt = false) {
  return {Pose(i), kSmall, in_doubt};
}

TEST(Recovery, ManyInliersWhereExpectedAreBelievedAtOnce) {
  Recovery recovery;
  EXPECT_EQ(recovery.Judge(Found(0, 60), Expected(0)), Verdict::kAsExpected);
}

TEST(Recovery, FewWaitForTheNextImage) {
  Recovery recovery;
  EXPECT_EQ(recovery.Judge(Found(0, 35), Expected(0)), Verdict::kWait);
  EXPECT_EQ(recovery.Judge(Found(1, 35), Expected(1)), Verdict::kAsExpected);
}

TEST(Recovery, AnImageWithoutVisionBeginsTheWaitAnew) {
  Recovery recovery;
  EXPECT_EQ(recovery.Judge(Found(0, 35), Expected(0)), Verdict::kWait);
  recovery.Reset();
  EXPECT_EQ(recovery.Judge(Found(1, 35), Expected(1)), Verdict::kWait);
}

TEST(Recovery, FewDoNotResolveADoubt) {
  Recovery recovery;
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(recovery.Judge(Found(i, 59), Expected(i, true)), Verdict::kWait);
  }
  EXPECT_EQ(recovery.Judge(Found(20, 60), Expected(20, true)), Verdict::kAsExpected);
}

TEST(Recovery, ElsewhereTakesManyInSeveralImagesThatAgree) {
  Recovery recovery;
  for (int i = 0; i < Recovery::kContradictingImages - 1; ++i) {
    EXPECT_EQ(recovery.Judge(Found(i, 90, 2.0), Expected(i)), Verdict::kWait) << i;
  }
  // The next one says something else.
  EXPECT_EQ(recovery.Judge(Found(4, 90, -1.0), Expected(4)), Verdict::kWait);
  for (int i = 5; i < 5 + Recovery::kContradictingImages - 2; ++i) {
    EXPECT_EQ(recovery.Judge(Found(i, 90, -1.0), Expected(i)), Verdict::kWait) << i;
  }
  EXPECT_EQ(recovery.Judge(Found(8, 90, -1.0), Expected(8)), Verdict::kElsewhere);
}

TEST(Recovery, WhereNothingIsExpectedItTakesTheSame) {
  Recovery recovery;
  for (int i = 0; i < Recovery::kContradictingImages - 1; ++i) {
    EXPECT_EQ(recovery.Judge(Found(i, 90), std::nullopt), Verdict::kWait) << i;
  }
  EXPECT_EQ(recovery.Judge(Found(4, 59), std::nullopt), Verdict::kWait);
  EXPECT_EQ(recovery.Judge(Found(5, 90), std::nullopt), Verdict::kElsewhere);
}

}  // namespace
}  // namespace gw::frontend

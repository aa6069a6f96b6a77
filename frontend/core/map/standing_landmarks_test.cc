#include "frontend/core/map/standing_landmarks.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

LandmarkId Id(int i) {
  return LandmarkId::From(KeyframeId{1}, i);
}

class Standing : public testing::Test {
 protected:
  // An image at t (s) that shows these landmarks.
  void See(double t, bool agreed, const std::vector<int>& ids) {
    std::vector<LandmarkId> inliers = {LandmarkId()};
    for (const int i : ids) inliers.push_back(Id(i));
    standing_.Observe({static_cast<int64_t>(t * 1e6)}, agreed, inliers);
  }

  StandingLandmarks standing_;
};

TEST_F(Standing, AgreementForAWhileProves) {
  for (const double t : {1.0, 1.1, 1.2, 1.3, 1.4}) See(t, true, {1});
  EXPECT_FALSE(standing_.Knows(Id(1))) << "not for half a second";
  See(1.5, true, {1, 2});
  EXPECT_TRUE(standing_.Knows(Id(1)));
  See(2.1, true, {2});
  EXPECT_FALSE(standing_.Knows(Id(2))) << "two images are too few";
  EXPECT_EQ(standing_.Count({Id(1), LandmarkId(), Id(2), Id(3)}), 1);
}

TEST_F(Standing, WhatMovesIsNotProvenByAFewImagesThatAgreeByChance) {
  for (int i = 0; i < 100; ++i) See(1 + 0.1 * i, i % 10 == 0, {1});
  EXPECT_FALSE(standing_.Knows(Id(1)));
  for (int i = 0; i < 20; ++i) See(11 + 0.1 * i, i % 3 != 0, {2});
  EXPECT_TRUE(standing_.Knows(Id(2))) << "a third contradicts where vision is too sure";
  See(13, false, {2});
  EXPECT_TRUE(standing_.Knows(Id(2))) << "what is proven stays so";
}

TEST_F(Standing, FollowsMerges) {
  for (const double t : {1.0, 1.2, 1.4, 1.6}) See(t, true, {1});
  See(1.7, true, {1, 2});
  standing_.Merge({{Id(1), Id(2)}, {Id(8), Id(9)}});
  EXPECT_FALSE(standing_.Knows(Id(1)));
  EXPECT_TRUE(standing_.Knows(Id(2)));
  EXPECT_FALSE(standing_.Knows(Id(9)));
}

TEST_F(Standing, ForgetsWhatIsLongOutOfSightAndAllOfAClockThatWasSetBack) {
  for (const double t : {1.0, 1.2, 1.4, 1.6}) See(t, true, {1, 2});
  for (double t = 2; t < 30; t += 0.5) See(t, true, {2});
  EXPECT_FALSE(standing_.Knows(Id(1)));
  EXPECT_TRUE(standing_.Knows(Id(2)));
  See(3, true, {});
  EXPECT_FALSE(standing_.Knows(Id(2)));
}

}  // namespace
}  // namespace gw::frontend

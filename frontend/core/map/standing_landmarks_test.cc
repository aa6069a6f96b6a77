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
  See(1, true, {1});
  See(1.4, true, {2});
  EXPECT_FALSE(standing_.Knows(Id(1)));
  See(1.5, true, {1, 2});
  EXPECT_TRUE(standing_.Knows(Id(1)));
  EXPECT_FALSE(standing_.Knows(Id(2)));
  EXPECT_EQ(standing_.Count({Id(1), LandmarkId(), Id(2), Id(3)}), 1);
}

TEST_F(Standing, AContradictionPutsOnlyInDoubtWhatIsNotProven) {
  See(1, true, {1});
  See(1.5, true, {1, 2});
  See(1.6, false, {1, 2});
  See(2.0, true, {1, 2});
  EXPECT_TRUE(standing_.Knows(Id(1)));
  EXPECT_FALSE(standing_.Knows(Id(2)));
  See(2.5, true, {2});
  EXPECT_TRUE(standing_.Knows(Id(2)));
}

TEST_F(Standing, FollowsMerges) {
  See(1, true, {1});
  See(1.5, true, {1, 2});
  standing_.Merge({{Id(1), Id(2)}, {Id(8), Id(9)}});
  EXPECT_FALSE(standing_.Knows(Id(1)));
  EXPECT_TRUE(standing_.Knows(Id(2)));
  EXPECT_FALSE(standing_.Knows(Id(9)));
}

TEST_F(Standing, ForgetsWhatIsLongOutOfSightAndAllOfAClockThatWasSetBack) {
  See(1, true, {1, 2});
  See(1.5, true, {1, 2});
  for (double t = 2; t < 30; t += 0.5) See(t, true, {2});
  EXPECT_FALSE(standing_.Knows(Id(1)));
  EXPECT_TRUE(standing_.Knows(Id(2)));
  See(3, true, {});
  EXPECT_FALSE(standing_.Knows(Id(2)));
}

}  // namespace
}  // namespace gw::frontend

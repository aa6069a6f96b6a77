#include "frontend/core/place/place_confirmation.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

constexpr int64_t kPeriodUs = 33333;

SE3 Odometry(int i) {
  return SE3(ExpSO3({0, 0, 0.002 * i}), {0.02 * i, 0, 0});
}

PlaceEvidence Image(int i, bool vision, int num_detected = 600) {
  PlaceEvidence e;
  e.utime = {i * kPeriodUs};
  e.placed = true;
  e.map_there = true;
  e.num_inliers = vision ? 150 : 0;
  e.num_detected = num_detected;
  e.T_OC = Odometry(i);
  return e;
}

PlaceMatch Match(int i, const SE3& T_WO) {
  PlaceMatch m;
  m.utime = {i * kPeriodUs};
  m.found = true;
  m.T_WC = T_WO * Odometry(i);
  m.cov_T_WC = Matrix6d::Identity() * 1e-4;
  m.num_sights = 80;
  return m;
}

const SE3 kElsewhere(ExpSO3({0, 0, 1.5}), {5, 3, 0});

// Tracks well for 30 images, then is carried away; returns the questions asked until image `to`.
int CarryAway(PlaceConfirmation& place, int to) {
  int asked = 0;
  for (int i = 0; i < to; ++i) asked += place.Observe(Image(i, i < 30)) ? 1 : 0;
  return asked;
}

TEST(PlaceConfirmation, ATrackerThatSeesAsksNothing) {
  PlaceConfirmation place;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(place.Observe(Image(i, true)));
  EXPECT_FALSE(place.in_doubt());
  EXPECT_FALSE(place.Take(Match(99, kElsewhere), Odometry(99)));
}

TEST(PlaceConfirmation, CarriedAwayMeansDoubtAtOnceAndQuestions) {
  PlaceConfirmation place;
  EXPECT_EQ(CarryAway(place, 31), 1);
  EXPECT_TRUE(place.in_doubt());
  int asked = 0;
  for (int i = 31; i < 61; ++i) asked += place.Observe(Image(i, false)) ? 1 : 0;
  EXPECT_GE(asked, 4);
  EXPECT_LE(asked, 5);  // one every 200 ms
}

// Dead reckoning has led for long, and goes on; only the images tell.
TEST(PlaceConfirmation, AnotherViewMeansDoubtAlsoWithoutVisionBefore) {
  PlaceConfirmation place;
  for (int i = 0; i < 60; ++i) place.Observe(Image(i, i < 30, i < 30 ? 600 : 5));
  EXPECT_FALSE(place.in_doubt());
  PlaceEvidence e = Image(60, false);
  e.view = ViewVerdict::kOther;
  place.Observe(e);
  EXPECT_TRUE(place.in_doubt());
  place.Observe(Image(61, false));
  EXPECT_TRUE(place.in_doubt());
}

TEST(PlaceConfirmation, AnotherViewWeighsMoreThanAFewMatches) {
  PlaceConfirmation place;
  for (int i = 0; i < 30; ++i) place.Observe(Image(i, true));
  PlaceEvidence e = Image(30, true);
  e.view = ViewVerdict::kOther;
  EXPECT_FALSE(place.Contradicts(e));  // 150 inliers
  e.num_inliers = 18;
  EXPECT_TRUE(place.Contradicts(e));
}

TEST(PlaceConfirmation, DarknessIsNoDoubt) {
  PlaceConfirmation place;
  for (int i = 0; i < 100; ++i) {
    const bool dark = i >= 30;
    EXPECT_FALSE(place.Observe(Image(i, !dark, dark ? 5 : 600)));
    EXPECT_FALSE(place.in_doubt());
  }
}

TEST(PlaceConfirmation, VisionThatReturnsEndsTheDoubt) {
  PlaceConfirmation place;
  CarryAway(place, 40);
  EXPECT_TRUE(place.in_doubt());
  EXPECT_FALSE(place.Observe(Image(40, true)));
  EXPECT_FALSE(place.in_doubt());
}

TEST(PlaceConfirmation, DoubtDoesNotEndByWaiting) {
  PlaceConfirmation place;
  CarryAway(place, 30 + 1800);  // a minute
  EXPECT_TRUE(place.in_doubt());
}

PlaceEvidence Weak(int i, int num_inliers) {
  PlaceEvidence e = Image(i, true);
  e.num_inliers = num_inliers;
  return e;
}

// Chance gives some inliers in any image.
TEST(PlaceConfirmation, InliersThatCollapseAreABreak) {
  PlaceConfirmation place;
  CarryAway(place, 30);
  EXPECT_TRUE(place.Contradicts(Weak(30, 18)));
  EXPECT_FALSE(place.Contradicts(Weak(30, 40)));   // more than chance gives
  EXPECT_FALSE(place.Contradicts(Weak(130, 18)));  // seconds later: vision may well have faded
  PlaceEvidence dark = Weak(30, 18);
  dark.num_detected = 60;
  EXPECT_FALSE(place.Contradicts(dark));
  PlaceEvidence turned = Weak(30, 18);
  turned.T_OC = Odometry(29) * SE3(ExpSO3({0, 0.3, 0}), Eigen::Vector3d::Zero());
  EXPECT_FALSE(place.Contradicts(turned));
  EXPECT_FALSE(place.in_doubt()) << "asking does not decide";
  place.Observe(Image(30, false));
  EXPECT_TRUE(place.in_doubt());
}

// Whether the robot was followed by its images, from good vision on, is known image by image.
TEST(PlaceConfirmation, ARobotIsFollowedWhileEachImageShowsTheOneBefore) {
  const auto followed = [](ViewVerdict second, bool dr_trusted) {
    PlaceConfirmation place;
    CarryAway(place, 30);
    for (int i = 30; i < 40; ++i) {
      PlaceEvidence e = Image(i, false);
      e.view = i == 31 ? second : ViewVerdict::kSame;
      e.dr_trusted = dr_trusted;
      place.Observe(e);
      EXPECT_TRUE(place.in_doubt());
    }
    return place.followed();
  };
  EXPECT_TRUE(followed(ViewVerdict::kSame, true));
  EXPECT_FALSE(followed(ViewVerdict::kUnknown, true));
  EXPECT_FALSE(followed(ViewVerdict::kOther, true));
  EXPECT_FALSE(followed(ViewVerdict::kSame, false));
}

TEST(PlaceConfirmation, AFewImagesBetweenGoodVisionAndNoneHideNothing) {
  PlaceConfirmation place;
  CarryAway(place, 30);
  for (int i = 30; i < 34; ++i) place.Observe(Weak(i, 40));
  EXPECT_FALSE(place.in_doubt());
  place.Observe(Image(34, false));
  EXPECT_TRUE(place.in_doubt());
}

// However few inliers a confirmed place was taken with: when they go, so does the claim.
TEST(PlaceConfirmation, ARelocalisationThatDoesNotHoldIsDoubted) {
  PlaceConfirmation place;
  CarryAway(place, 40);
  PlaceEvidence snap = Weak(40, 35);
  snap.relocalised = true;
  place.Observe(snap);
  EXPECT_FALSE(place.in_doubt());
  place.Observe(Weak(41, 20));
  place.Observe(Weak(42, 14));
  EXPECT_FALSE(place.in_doubt());
  PlaceEvidence lost = Image(43, false);
  lost.view = ViewVerdict::kSame;
  place.Observe(lost);
  EXPECT_TRUE(place.in_doubt());
  EXPECT_FALSE(place.followed()) << "the images fit each other at any place";
  // Once it was well tracked it is a place like any other, where weak vision may fade.
  snap.utime = {50 * kPeriodUs};
  snap.T_OC = Odometry(50);
  place.Observe(snap);
  for (int i = 51; i < 61; ++i) place.Observe(Weak(i, 100));
  for (int i = 61; i < 75; ++i) place.Observe(Weak(i, 35));
  place.Observe(Image(75, false));
  EXPECT_FALSE(place.in_doubt());
}

TEST(PlaceConfirmation, WithoutVisionForASecondItAsks) {
  PlaceConfirmation place;
  int first = -1;
  for (int i = 0; i < 100; ++i) {
    // Vision fades: no sudden break.
    PlaceEvidence e = Image(i, i < 30);
    if (i >= 5 && i < 30) e.num_inliers = 40;
    if (place.Observe(e) && first < 0) first = i;
  }
  EXPECT_FALSE(place.in_doubt());
  EXPECT_NEAR(first, 29 + 30, 2);
}

TEST(PlaceConfirmation, ThreeAnswersThatAgreeAreBelieved) {
  PlaceConfirmation place;
  CarryAway(place, 60);
  EXPECT_FALSE(place.Take(Match(40, kElsewhere), Odometry(40)));
  EXPECT_FALSE(place.Take(Match(46, kElsewhere), Odometry(46)));
  const auto confirmed = place.Take(Match(52, kElsewhere), Odometry(52));
  ASSERT_TRUE(confirmed);
  EXPECT_LT((confirmed->T_WO.inverse() * kElsewhere).Log().norm(), 1e-9);
}

TEST(PlaceConfirmation, TheSameAnswerTwiceCountsOnce) {
  PlaceConfirmation place;
  CarryAway(place, 60);
  for (int k = 0; k < 5; ++k) EXPECT_FALSE(place.Take(Match(40, kElsewhere), Odometry(40)));
}

TEST(PlaceConfirmation, AnswersThatContradictEachOtherNeedMore) {
  PlaceConfirmation place;
  CarryAway(place, 100);
  const SE3 other(Eigen::Quaterniond::Identity(), {-8, 0, 0});
  EXPECT_FALSE(place.Take(Match(40, kElsewhere), Odometry(40)));
  EXPECT_FALSE(place.Take(Match(46, other), Odometry(46)));
  EXPECT_FALSE(place.Take(Match(52, kElsewhere), Odometry(52)));
  EXPECT_FALSE(place.Take(Match(58, kElsewhere), Odometry(58)));
  EXPECT_TRUE(place.Take(Match(64, kElsewhere), Odometry(64)));
}

TEST(PlaceConfirmation, NotFoundIsNoAnswer) {
  PlaceConfirmation place;
  CarryAway(place, 60);
  PlaceMatch nothing = Match(40, kElsewhere);
  nothing.found = false;
  for (int i = 40; i < 50; ++i) {
    nothing.utime = {i * kPeriodUs};
    EXPECT_FALSE(place.Take(nothing, Odometry(i)));
  }
}

TEST(PlaceConfirmation, AStartInASavedMapAsks) {
  PlaceConfirmation place;
  PlaceEvidence e = Image(0, false);
  e.placed = false;
  EXPECT_TRUE(place.Observe(e));
  e.utime = {kPeriodUs};
  EXPECT_FALSE(place.Observe(e));  // not every image
  e.map_there = false;
  e.utime = {20 * kPeriodUs};
  EXPECT_FALSE(place.Observe(e));
}

}  // namespace
}  // namespace gw::frontend

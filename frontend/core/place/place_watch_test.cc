#include "frontend/core/place/place_watch.h"

#include <gtest/gtest.h>

#include "frontend/core/features/test_camera.h"
#include "frontend/core/place/test_view.h"

namespace gw::frontend {
namespace {

constexpr KeyframeId kPiece{7};

// A robot that drives straight at 0.6 m/s, 30 images a second, and is carried away after 30 images.
class PlaceWatchTest : public testing::Test {
 protected:
  static Utime Time(int i) { return {i * 33'333}; }
  static SE3 Odometry(int i) { return SE3(Eigen::Quaterniond::Identity(), {0.02 * i, 0, 0}); }

  PlaceWatch::Verdict See(int i) {
    PlaceEvidence e;
    e.utime = Time(i);
    e.placed = e.map_there = true;
    e.num_inliers = i < 30 ? 150 : 0;
    e.num_detected = 600;
    e.T_OC = Odometry(i);
    return watch_.Observe(e, {}, true);
  }

  void CarryAway() {
    for (int i = 0; i < 40; ++i) See(i);
  }

  void AnswerThreeTimes() {
    for (int i = 36; i < 39; ++i) {
      PlaceMatch match;
      match.utime = Time(i);
      match.found = true;
      match.T_WC = T_WO_ * Odometry(i);
      watch_.Answer(match, Odometry(i), kPiece);
    }
  }

  const SE3 T_WO_{ExpSO3({0, 0, 1.5}), {5, 3, 0}};
  PlaceWatch watch_{TestCamera(6), true};
};

TEST_F(PlaceWatchTest, IsSureWhileVisionCarriesThePose) {
  for (int i = 0; i < 30; ++i) {
    const auto verdict = See(i);
    EXPECT_TRUE(verdict.sure);
    EXPECT_FALSE(verdict.ask);
  }
  const auto verdict = See(30);
  EXPECT_FALSE(verdict.sure);
  EXPECT_TRUE(verdict.ask);
}

TEST_F(PlaceWatchTest, AConfirmedPlaceIsTakenOnceAndInItsPiece) {
  CarryAway();
  EXPECT_FALSE(watch_.TakeConfirmed());
  AnswerThreeTimes();
  const auto confirmed = watch_.TakeConfirmed();
  ASSERT_TRUE(confirmed);
  EXPECT_EQ(confirmed->piece, kPiece);
  EXPECT_LT((confirmed->T_WO.inverse() * T_WO_).Log().norm(), 1e-9);
  EXPECT_FALSE(watch_.TakeConfirmed());
}

TEST_F(PlaceWatchTest, AClockThatIsSetBackEndsDoubtAndAnswers) {
  CarryAway();
  AnswerThreeTimes();
  EXPECT_TRUE(watch_.in_doubt());
  watch_.Restart();
  EXPECT_FALSE(watch_.in_doubt());
  EXPECT_FALSE(watch_.TakeConfirmed());
}

TEST_F(PlaceWatchTest, APieceThatIsBegunIsAKnownPlace) {
  CarryAway();
  watch_.BeginPiece();
  EXPECT_FALSE(watch_.in_doubt());
}

// A robot whose vision breaks after 30 images, while it drives on at 0.3 m/s; its images are of
// scene 1, then of `scene`. True: the doubt ends. False: a piece of the map is to be begun.
bool DoubtEnds(uint64_t scene) {
  PlaceWatch watch(TestCamera(6), true);
  for (int i = 0; i < 300; ++i) {
    const bool broken = i >= 30;
    const SE3 T_OC(Eigen::Quaterniond::Identity(), {0, 0, 0.01 * i});
    const FeatureFrame frame = SeeScene(broken ? scene : 1, T_OC, i);
    watch.CompareViews(frame, T_OC, broken);
    PlaceEvidence e;
    e.utime = {i * 33'333};
    e.placed = e.map_there = true;
    e.num_inliers = broken ? 0 : 150;
    e.num_detected = 600;
    e.T_OC = T_OC;
    const PlaceWatch::Verdict verdict = watch.Observe(e, frame, true);
    EXPECT_TRUE(!broken || watch.in_doubt() || verdict.sure);
    if (verdict.map_on || (broken && verdict.sure)) {
      EXPECT_GT(i, 30 + 90) << "not before the patience ends";
      EXPECT_NE(verdict.map_on, verdict.sure);
      return verdict.sure;
    }
  }
  ADD_FAILURE() << "neither";
  return false;
}

TEST(PlaceWatch, ADoubtEndsWhereTheImagesFollowedTheRobot) {
  EXPECT_TRUE(DoubtEnds(1));
  EXPECT_FALSE(DoubtEnds(2)) << "carried away";
}

}  // namespace
}  // namespace gw::frontend

#include "dr_ekf/core/vision_witness.h"

#include <gtest/gtest.h>

namespace gw::dr_ekf {
namespace {

// Wheels at 50 Hz, images at 30 Hz, both along x.
class VisionWitnessTest : public testing::Test {
 protected:
  // What is said last, after driving on for `ms`.
  std::optional<VisionVerdict> Drive(int ms, double wheel_speed, double vision_speed) {
    std::optional<VisionVerdict> last;
    for (const int end = now_ms_ + ms; now_ms_ < end; ++now_ms_) {
      vision_m_ += vision_speed / 1000;
      wheels_m_ += wheel_speed / 1000;
      if (now_ms_ % 20 == 0) {
        WheelSample s;
        s.utime = {now_ms_ * 1000};
        s.utime_begin = {(now_ms_ - 20) * 1000};
        s.dx_m = wheels_m_;
        wheels_m_ = 0;
        const auto verdict = witness_.Push(s, 1.0);
        if (verdict) last = verdict;
      }
      if (now_ms_ % 33 == 0) {
        frame_.utime = {now_ms_ * 1000};
        frame_.T_WB = SE3(Eigen::Quaterniond::Identity(), {vision_m_, aside_ * vision_m_, 0});
        if (new_map_every_image_) ++frame_.map_revision;
        if (frame_.reference_keyframe.valid()) {
          frame_.T_KC = T_BC_.inverse() * frame_.T_WB * T_BC_;
          frame_.T_WB = SE3(Eigen::Quaterniond::Identity(), {0, now_ms_ % 2 ? 1. : -1., 0});
        }
        const auto verdict = witness_.Push(frame_);
        if (verdict) last = verdict;
      }
    }
    return last;
  }

  void SetUp() override {
    frame_.status = TrackingStatus::kTracking;
    frame_.q = 1;
    frame_.dr_share = 0.001;
  }

  FramePose frame_;
  double aside_ = 0;
  bool new_map_every_image_ = false;

 private:
  SE3 T_BC_{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.25}};
  VisionWitness witness_{T_BC_};
  int now_ms_ = 1000;
  double vision_m_ = 0, wheels_m_ = 0;
};

TEST_F(VisionWitnessTest, ConfirmsWheelsThatAreRight) {
  const auto verdict = Drive(1000, 0.4, 0.41);
  ASSERT_TRUE(verdict);
  EXPECT_TRUE(verdict->agrees);
}

TEST_F(VisionWitnessTest, AccusesWheelsThatTurnTwiceAsFastWithinAFifthOfASecond) {
  for (const double speed : {0.2, 0.6}) {
    Drive(1000, speed, speed);
    const auto verdict = Drive(220, 2 * speed, speed);
    ASSERT_TRUE(verdict) << speed;
    EXPECT_FALSE(verdict->agrees) << speed;
    EXPECT_GT(verdict->speed_excess, 0.3 * speed);
    EXPECT_LE(verdict->speed_excess, 1.05 * speed);
  }
}

// Wheels of a wrong scale are no slip; those that spin on the spot are, however long.
TEST_F(VisionWitnessTest, ASlipIsShort) {
  for (const double factor : {2.0, 0.5, -1.0}) {
    Drive(500, 0, 0);
    const auto at_first = Drive(1000, factor * 0.5, 0.5);
    ASSERT_TRUE(at_first) << factor;
    EXPECT_FALSE(at_first->agrees) << factor;
    Drive(6000, factor * 0.5, 0.5);
    EXPECT_FALSE(Drive(2000, factor * 0.5, 0.5)) << factor;
  }
  Drive(500, 0, 0);
  Drive(8000, 0.5, 0);
  const auto spinning = Drive(500, 0.5, 0);
  ASSERT_TRUE(spinning);
  EXPECT_FALSE(spinning->agrees);
}

TEST_F(VisionWitnessTest, SaysNothingOfALittleDisagreement) {
  EXPECT_FALSE(Drive(1000, 0.4, 0.325));
}

TEST_F(VisionWitnessTest, IsSilentWhileVisionIsNotHealthy) {
  frame_.dr_share = 0.6;  // mostly the accused themselves
  EXPECT_FALSE(Drive(1000, 0.8, 0.4));
  frame_.dr_share = 0.001;
  frame_.q = 0.7;
  EXPECT_FALSE(Drive(1000, 0.8, 0.4));
  frame_.q = 1;
  frame_.status = TrackingStatus::kDegraded;
  EXPECT_FALSE(Drive(1000, 0.8, 0.4));
}

TEST_F(VisionWitnessTest, VisionThatGoesSidewaysIsNotBelieved) {
  aside_ = 1.0;
  EXPECT_FALSE(Drive(1000, 0.8, 0.4));
}

TEST_F(VisionWitnessTest, ImagesOfDifferentMapsAreNotCompared) {
  new_map_every_image_ = true;
  EXPECT_FALSE(Drive(1000, 0.8, 0.4));
}

// The map may move the keyframe, and the pose with it, by a metre: beside the keyframe it stands.
TEST_F(VisionWitnessTest, ImagesOfDifferentMapsAreComparedBesideOneKeyframe) {
  new_map_every_image_ = true;
  frame_.reference_keyframe = KeyframeId{7};
  const auto wrong = Drive(1000, 0.8, 0.4);
  ASSERT_TRUE(wrong);
  EXPECT_FALSE(wrong->agrees);
  EXPECT_NEAR(wrong->speed_excess, 0.4, 0.02);
  const auto right = Drive(1000, 0.4, 0.4);
  ASSERT_TRUE(right);
  EXPECT_TRUE(right->agrees);
}

}  // namespace
}  // namespace gw::dr_ekf

#include "dr_ekf/pose/pose_glide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/core/random.h"
#include "dr_ekf/core/pose_composer.h"

namespace gw::dr_ekf {
namespace {

constexpr GlideRates kRates{0.1, 0.09};
constexpr double kDt = 0.01;  // s between two states
// Rounding of a pose that has been composed and inverted.
constexpr double kRounding = 1e-9;

SE3 Planar(double x, double y, double yaw) {
  return SE3(ExpSO3({0, 0, yaw}), {x, y, 0});
}

double Way(const SE3& T) {
  return T.translation().norm();
}

double Turn(const SE3& T) {
  return LogSO3(T.rotation()).norm();
}

// A corrected pose of a robot whose dead reckoning says T_OB.
Pose Corrected(int k, const SE3& T_WO, const SE3& T_OB) {
  Pose pose;
  pose.utime = {static_cast<int64_t>(k) * 10'000};
  pose.T_WO = T_WO;
  pose.T_WB = T_WO * T_OB;
  pose.cov_T_WB = Matrix6d::Identity() * 1e-4;
  const Matrix6d adj = T_OB.Adjoint();
  pose.cov_T_WO = adj * pose.cov_T_WB * adj.transpose();
  pose.has_map = true;
  return pose;
}

struct Drive {
  std::vector<SE3> T_OB;
  std::vector<Pose> corrected, published;
};

// Curves and standstills at random, and corrections of up to 0.5 m and 20 degrees, from several a
// second to none for seconds.
Drive RandomDrive(uint64_t seed, const GlideRates& rates) {
  CounterRng rng(seed, 1, 0);
  PoseGlide glide(rates);
  Drive drive;
  SE3 T_OB, T_WO = Planar(rng.Uniform(-20, 20), rng.Uniform(-20, 20), rng.Uniform(-3, 3));
  double v = 0, w = 0;
  const double often = std::pow(10, rng.Uniform(-3, -0.5));
  for (int k = 0; k < 600; ++k) {
    if (rng.Uniform() < 0.02) {
      v = rng.Uniform(-0.2, 0.7);
      w = rng.Uniform(-1.5, 1.5);
    }
    T_OB = T_OB * SE3::Exp((Vector6d() << v * kDt, 0, 0, 0, 0, w * kDt).finished());
    if (rng.Uniform() < often) {
      Vector6d jump;
      for (int i = 0; i < 6; ++i) jump[i] = rng.Uniform(-1, 1) * (i < 3 ? 0.3 : 0.2);
      // At the robot, not at the origin of W.
      T_WO = T_WO * T_OB * SE3::Exp(jump) * T_OB.inverse();
    }
    drive.T_OB.push_back(T_OB);
    drive.corrected.push_back(Corrected(k, T_WO, T_OB));
    drive.published.push_back(glide.Push(drive.corrected.back(), false));
  }
  return drive;
}

TEST(PoseGlide, NoStepIsLargerThanTheMotionAndTheRateWhateverIsCorrected) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const Drive drive = RandomDrive(seed, kRates);
    for (size_t k = 1; k < drive.T_OB.size(); ++k) {
      const SE3 motion = drive.T_OB[k - 1].inverse() * drive.T_OB[k];
      const SE3 step = drive.published[k - 1].T_WB.inverse() * drive.published[k].T_WB;
      ASSERT_LE(Way(step), Way(motion) + kRates.m_s * kDt + kRounding) << seed << " " << k;
      ASSERT_LE(Turn(step), Turn(motion) + kRates.rad_s * kDt + kRounding) << seed << " " << k;
      ASSERT_EQ(drive.published[k].reset_counter, 0u);
    }
  }
}

// Wheels that count backwards, and wheels that stand, while vision, ten times a second, says how
// the robot drives: the pose follows vision. A loop meanwhile is gone over to at the usual rate.
TEST(PoseGlide, FollowsAMotionThatDeadReckoningDoesNotTell) {
  for (const double told : {-0.5, 0.0}) {
    PoseGlide glide(kRates);
    const double driven = 0.5;  // m/s
    SE3 T_OB, T_WB, T_WO;
    Pose pose;
    double worst = 0;
    for (int k = 0; k < 1000; ++k) {
      T_OB = T_OB * Planar(told * kDt, 0, 0);
      T_WB = T_WB * Planar(driven * kDt, 0, 0);
      if (k == 600) T_WB = T_WB * Planar(0, 0.3, 0);
      if (k % 10 == 0) T_WO = T_WB * T_OB.inverse();
      Pose corrected = Corrected(k, T_WO, T_OB);
      corrected.frame_pose_seq = k / 10;
      const Pose next = glide.Push(corrected, false);
      const SE3 error = next.T_WB.inverse() * T_WB;
      if (k > 200 && k < 600) worst = std::max(worst, Way(error));
      if (k > 600) {
        const double aside = std::abs((pose.T_WB.inverse() * next.T_WB).translation().y());
        ASSERT_LE(aside, 0.2 * kRates.m_s) << k;
      }
      if (k > 990) {
        EXPECT_LT(Way(error), 0.15) << told;
      }
      pose = next;
    }
    EXPECT_LT(worst, 0.15) << told;
  }
}

// What vision errs by at random is no motion.
TEST(PoseGlide, TakesNoiseForNoMotion) {
  CounterRng rng(5, 1, 0);
  PoseGlide glide(kRates);
  SE3 T_OB, T_WO;
  Pose pose;
  for (int k = 0; k < 5000; ++k) {
    T_OB = T_OB * Planar(0.5 * kDt, 0, 0);
    if (k % 10 == 0) {
      T_WO = T_OB * Planar(0.02 * rng.Normal(), 0.02 * rng.Normal(), 0) * T_OB.inverse();
    }
    Pose corrected = Corrected(k, T_WO, T_OB);
    corrected.frame_pose_seq = k / 10;
    const Pose next = glide.Push(corrected, false);
    if (k > 0) {
      ASSERT_LE(Way(pose.T_WB.inverse() * next.T_WB), 0.5 * kDt + kRates.m_s * kDt + kRounding);
    }
    pose = next;
  }
}

TEST(PoseGlide, CovarianceHoldsWhatIsOutstanding) {
  double most = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const Drive drive = RandomDrive(seed, kRates);
    for (size_t k = 0; k < drive.T_OB.size(); ++k) {
      const Pose& published = drive.published[k];
      const Vector6d e = (published.T_WB.inverse() * drive.corrected[k].T_WB).Log();
      const Matrix6d known = published.cov_T_WB - drive.corrected[k].cov_T_WB;
      ASSERT_LT((known - e * e.transpose()).norm(), 1e-9) << seed << " " << k;
      // T_WO tells the same: its error is that of T_WB, moved to O.
      const Matrix6d adj = drive.T_OB[k].Adjoint();
      ASSERT_LT((published.cov_T_WO - adj * published.cov_T_WB * adj.transpose()).norm(), 1e-6);
      ASSERT_LT((published.T_WO * drive.T_OB[k] * published.T_WB.inverse()).Log().norm(), 1e-9);
      most = std::max(most, e.norm());
    }
  }
  EXPECT_GT(most, 0.3);  // There was something to hold.
}

TEST(PoseGlide, ArrivesExactlyWhenTheRateAllowsAndGoesOnAsComposed) {
  PoseGlide glide(kRates);
  SE3 T_OB;
  glide.Push(Corrected(0, SE3(), T_OB), false);
  // 0.3 m to the side and 0.09 rad: 3 s and 1 s, while it drives straight on. The heading that is
  // outstanding moves the place by some centimetres more.
  const SE3 T_WO = Planar(0, 0.3, 0.09);
  std::vector<double> left;
  for (int k = 1; k <= 400; ++k) {
    T_OB = T_OB * Planar(0.3 * kDt, 0, 0);
    const Pose corrected = Corrected(k, T_WO, T_OB);
    const Pose published = glide.Push(corrected, false);
    left.push_back(Way(published.T_WB.inverse() * corrected.T_WB));
    if (k <= 290) {
      EXPECT_GT(left.back(), 0) << k;
    }
    if (k == 110) {
      EXPECT_EQ(Turn(published.T_WB.inverse() * corrected.T_WB), 0);
    }
    if (k < 330) continue;
    EXPECT_EQ(published.T_WB.translation(), corrected.T_WB.translation());
    EXPECT_EQ(published.T_WO.translation(), T_WO.translation());
    EXPECT_EQ(published.cov_T_WB, corrected.cov_T_WB);
  }
  for (size_t k = 110; k < left.size(); ++k) EXPECT_LE(left[k], left[k - 1]);
}

TEST(PoseGlide, CorrectsAtOnceWhenStandingStillOrWhenTheRatesAreZero) {
  for (const bool at_once : {false, true}) {
    PoseGlide glide(at_once ? GlideRates{} : kRates);
    glide.Push(Corrected(0, SE3(), SE3()), false);
    const Pose corrected = Corrected(1, Planar(0.4, 0.1, 0.3), SE3());
    const Pose published = glide.Push(corrected, !at_once);
    EXPECT_EQ(published.T_WB.translation(), corrected.T_WB.translation());
    EXPECT_EQ(published.cov_T_WB, corrected.cov_T_WB);
    EXPECT_EQ(published.reset_counter, 0u);
  }
}

TEST(PoseGlide, SnapsAndAnnouncesItWhenThePlaceWasInDoubt) {
  PoseGlide glide(kRates);
  glide.Push(Corrected(0, SE3(), SE3()), false);
  Pose doubt = Corrected(1, SE3(), SE3());
  doubt.cov_T_WB = Matrix6d::Identity() * 100;
  EXPECT_EQ(glide.Push(doubt, false).reset_counter, 0u);
  const Pose found = Corrected(2, Planar(7, -3, 2), SE3());
  const Pose published = glide.Push(found, false);
  EXPECT_EQ(published.reset_counter, 1u);
  EXPECT_EQ(published.T_WB.translation(), found.T_WB.translation());
  EXPECT_EQ(glide.Push(Corrected(3, Planar(7, -3, 2), SE3()), false).reset_counter, 1u);
}

TEST(PoseGlide, TheFirstPlaceInAMapIsASnapToo) {
  PoseGlide glide(kRates);
  Pose without = Corrected(0, SE3(), SE3());
  without.has_map = false;
  glide.Push(without, false);
  const Pose published = glide.Push(Corrected(1, Planar(3, 0, 1), SE3()), false);
  EXPECT_EQ(published.reset_counter, 1u);
  EXPECT_EQ(published.T_WB.translation().x(), 3);
}

// With the composer: T_WB goes on where it was, and so does what is outstanding.
TEST(PoseGlide, IsNotDisturbedWhenDeadReckoningBeginsAnew) {
  PoseComposer composer;
  PoseGlide glide(kRates);
  const auto state = [](int ms, uint32_t counter, const SE3& T_OB) {
    DrState s;
    s.utime = {ms * 1000};
    s.reset_counter = counter;
    s.T_OB = T_OB;
    return s;
  };
  FramePose frame;
  frame.status = TrackingStatus::kTracking;
  frame.cov_T_WB = Matrix6d::Identity() * 1e-6;
  glide.Push(*composer.Push(state(0, 0, SE3())), false);
  composer.Push(frame);
  glide.Push(*composer.Push(state(10, 0, SE3())), false);
  frame.utime = {10'000};
  frame.T_WB = Planar(0.2, 0, 0);
  composer.Push(frame);
  const Pose before = glide.Push(*composer.Push(state(20, 0, SE3())), false);
  EXPECT_NEAR(before.T_WB.translation().x(), kRates.m_s * kDt, 1e-9);
  const Pose after = glide.Push(*composer.Push(state(30, 1, Planar(-20, 4, 2))), false);
  EXPECT_NEAR(after.T_WB.translation().x(), 2 * kRates.m_s * kDt, 1e-9);
  EXPECT_LT(Way(before.T_WB.inverse() * after.T_WB), kRates.m_s * kDt + kRounding);
}

TEST(PoseGlide, SameCallsSameBytes) {
  const Drive a = RandomDrive(7, kRates), b = RandomDrive(7, kRates);
  for (size_t k = 0; k < a.published.size(); ++k) {
    ASSERT_EQ(a.published[k].T_WB.translation(), b.published[k].T_WB.translation());
    ASSERT_EQ(a.published[k].T_WB.rotation().coeffs(), b.published[k].T_WB.rotation().coeffs());
    ASSERT_EQ(a.published[k].cov_T_WB, b.published[k].cov_T_WB);
  }
}

}  // namespace
}  // namespace gw::dr_ekf

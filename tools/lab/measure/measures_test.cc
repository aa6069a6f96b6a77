#include "tools/lab/measure/measures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw::measure {
namespace {

constexpr int64_t kPeriodUs = 33333;

SE3 TruePose(int i) {
  const double t = i * kPeriodUs * 1e-6;
  return SE3(ExpSO3({0, 0, 0.3 * t}), {2 * std::sin(0.3 * t), 2 - 2 * std::cos(0.3 * t), 0});
}

eval::Trajectory Truth(int images) {
  eval::Trajectory out;
  for (int i = 0; i < images; ++i) out.push_back({{i * kPeriodUs}, TruePose(i)});
  return out;
}

// A run that knows the truth.
SlamRun PerfectRun(int images) {
  SlamRun run;
  for (int i = 0; i < images; ++i) {
    FramePose f;
    f.utime = {i * kPeriodUs};
    f.status = TrackingStatus::kTracking;
    f.T_WB = TruePose(i);
    run.frames.push_back(f);
    run.final_T_WB.push_back(f.T_WB);
    run.T_OB.emplace_back(f.T_WB);
    run.ms.emplace_back(i);
  }
  return run;
}

Vector6d Noise(CounterRng& rng, const Vector6d& sigma) {
  Vector6d out;
  for (int k = 0; k < 6; ++k) out[k] = sigma[k] * rng.Normal();
  return out;
}

Vector6d Sigmas() {
  Vector6d sigma;
  sigma << 0.01, 0.02, 0.005, 0.001, 0.002, 0.004;
  return sigma;
}

constexpr int kSecond = 30;  // images

Matrix6d CarriedTo(const FramePose& b, const FramePose& a, const Matrix6d& cov) {
  const Matrix6d Ad = (b.T_WB.inverse() * a.T_WB).Adjoint();
  return Ad * cov * Ad.transpose();
}

// Every image placed by itself, with an error of a known spread.
SlamRun IndependentErrors(int images, double stated_over_true) {
  SlamRun run = PerfectRun(images);
  for (int i = 0; i < images; ++i) {
    CounterRng rng(1, 0, i);
    run.frames[i].T_WB = TruePose(i) * SE3::Exp(Noise(rng, Sigmas()));
    FramePose& b = run.frames[i];
    b.cov_T_WB = (stated_over_true * Sigmas()).cwiseAbs2().asDiagonal();
    if (i < kSecond) continue;
    const FramePose& a = run.frames[i - kSecond];
    b.motion_us = kSecond * kPeriodUs;
    b.cov_motion = b.cov_T_WB + CarriedTo(b, a, a.cov_T_WB);
  }
  return run;
}

TEST(Consistency, HonestIndependentErrorsAreInsideTheBand) {
  const Consistency c = MeasureConsistency(IndependentErrors(3000, 1.0), Truth(3000));
  EXPECT_EQ(c.healthy.windows, 3000 - 30);
  EXPECT_EQ(c.blind.windows, 0);
  EXPECT_NEAR(c.healthy.share_inside(), 0.95, 0.02);
}

TEST(Consistency, TellsTooSureFromTooCareful) {
  const Consistency sure = MeasureConsistency(IndependentErrors(1000, 0.3), Truth(1000));
  EXPECT_LT(sure.healthy.share_inside(), 0.2);
  EXPECT_GT(sure.healthy.above, 800);
  const Consistency careful = MeasureConsistency(IndependentErrors(1000, 5.0), Truth(1000));
  EXPECT_LT(careful.healthy.share_inside(), 0.2);
  EXPECT_EQ(careful.healthy.above, 0);
}

TEST(Consistency, BlindErrorsGrowFromImageToImage) {
  constexpr int kImages = 3000;
  SlamRun run = PerfectRun(kImages);
  const Matrix6d step = (0.1 * Sigmas()).cwiseAbs2().asDiagonal();
  run.frames[0].T_WB = TruePose(0);
  run.frames[0].status = TrackingStatus::kDrOnly;
  for (int i = 1; i < kImages; ++i) {
    CounterRng rng(2, 0, i);
    const SE3 motion =
        TruePose(i - 1).inverse() * TruePose(i) * SE3::Exp(Noise(rng, 0.1 * Sigmas()));
    run.frames[i].T_WB = run.frames[i - 1].T_WB * motion;
    run.frames[i].status = TrackingStatus::kDrOnly;
    if (i < kSecond) continue;
    FramePose& b = run.frames[i];
    b.motion_us = kSecond * kPeriodUs;
    for (int k = i - kSecond + 1; k <= i; ++k) b.cov_motion += CarriedTo(b, run.frames[k], step);
  }
  const Consistency c = MeasureConsistency(run, Truth(kImages));
  EXPECT_EQ(c.healthy.windows, 0);
  EXPECT_EQ(c.blind.windows, kImages - 30);
  EXPECT_NEAR(c.blind.share_inside(), 0.95, 0.04);  // 99 windows are independent
}

TEST(Consistency, WindowsWithAnImageWithoutPoseDoNotCountAndBadCovariancesAreNotInside) {
  SlamRun run = IndependentErrors(100, 1.0);
  run.frames[50].status = TrackingStatus::kLost;
  EXPECT_EQ(MeasureConsistency(run, Truth(100)).healthy.windows, 100 - 30 - 31);
  for (FramePose& f : run.frames) f.cov_motion.setZero();
  const Consistency c = MeasureConsistency(run, Truth(100));
  EXPECT_EQ(c.healthy.undefined, c.healthy.windows);
  EXPECT_EQ(c.healthy.inside, 0);
}

TEST(Jumps, AreWhatDeadReckoningDoesNotExplain) {
  SlamRun run = PerfectRun(60);
  EXPECT_NEAR(MeasureJumps(run).worst_m, 0, 1e-12);
  for (int i = 20; i < 60; ++i) {
    run.frames[i].T_WB = SE3(ExpSO3({0, 0, 0}), {0.3, 0.4, 0}) * run.frames[i].T_WB;
  }
  EXPECT_NEAR(MeasureJumps(run).worst_m, 0.5, 1e-9);
  EXPECT_NEAR(MeasureJumps(run).worst_recovery_m, 0, 1e-12);
  for (int i = 10; i < 20; ++i) run.frames[i].status = TrackingStatus::kDrOnly;
  EXPECT_NEAR(MeasureJumps(run).worst_m, 0, 1e-12);
  EXPECT_NEAR(MeasureJumps(run).worst_recovery_m, 0.5, 1e-9);
}

TEST(Measures, CountAndCompare) {
  SlamRun run = PerfectRun(100);
  run.frames[0].status = TrackingStatus::kInitializing;
  for (int i = 40; i < 60; ++i) run.frames[i].status = TrackingStatus::kDrOnly;
  for (int i = 60; i < 69; ++i) run.frames[i].status = TrackingStatus::kLost;
  for (int i = 0; i < 100; ++i) {
    // A height that changes sign is an error that no alignment of this flat path takes away.
    const double z = i % 2 == 0 ? 0.1 : -0.1;
    run.frames[i].T_WB = SE3(Eigen::Quaterniond::Identity(), {0, 0, z}) * run.frames[i].T_WB;
  }
  const Measures m = Measure(run, Truth(100), eval::Alignment::kSe3);
  EXPECT_EQ(m.images, 100);
  EXPECT_EQ(m.lost, 10);
  EXPECT_EQ(m.blind, 20);
  EXPECT_DOUBLE_EQ(m.tracked_share(), 0.9);
  ASSERT_TRUE(m.ape_live_m && m.ape_final_m && m.ape_dr_m && m.ms_median && m.ms_p99);
  EXPECT_NEAR(*m.ape_live_m, 0.1, 1e-3);
  EXPECT_NEAR(*m.ape_final_m, 0, 1e-9);
  EXPECT_NEAR(*m.ape_dr_m, 0, 1e-9);
  EXPECT_DOUBLE_EQ(*m.ms_median, 49.5);
  EXPECT_DOUBLE_EQ(*m.ms_p99, 98);
}

TEST(Measures, WhatCannotBeMeasuredIsEmpty) {
  SlamRun run = PerfectRun(50);
  for (auto& T : run.T_OB) T.reset();
  for (auto& ms : run.ms) ms.reset();
  const Measures m = Measure(run, {}, eval::Alignment::kSe3);
  EXPECT_FALSE(m.ape_live_m || m.ape_dr_m || m.rpe_m || m.ms_median);
  EXPECT_EQ(m.consistency.healthy.windows, 0);
}

}  // namespace
}  // namespace gw::measure

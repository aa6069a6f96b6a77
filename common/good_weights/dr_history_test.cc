#include "common/good_weights/dr_history.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace gw {
namespace {

// Drives straight along x at 1 m/s, states every 10 ms.
DrHistory StraightDrive(int num_states, int reset_at = -1) {
  DrHistory history;
  uint32_t counter = 0;
  for (int i = 0; i < num_states; ++i) {
    if (i == reset_at) ++counter;
    DrState s;
    s.utime = {i * 10000};
    s.T_OB = SE3(Eigen::Quaterniond::Identity(), {0.01 * i, 0, 0});
    s.v_OB_B = {1, 0, 0};
    s.reset_counter = counter;
    s.cov_twist_white = Matrix6d::Identity() * 0.5;
    s.cov_twist_coherent = Matrix6d::Identity() * 0.25;
    EXPECT_TRUE(history.Push(s));
  }
  return history;
}

TEST(DrHistory, IncrementInterpolatesBothEnds) {
  const DrHistory history = StraightDrive(101);
  const auto increment = history.Increment({123456}, {654321});
  ASSERT_TRUE(increment);
  EXPECT_NEAR(increment->T_BaBb.translation().x(), 0.530865, 1e-9);
}

TEST(DrHistory, RefusesWhatItDoesNotCover) {
  const DrHistory history = StraightDrive(101);
  EXPECT_FALSE(history.Increment({-1}, {100}));
  EXPECT_FALSE(history.Increment({0}, {1500001}));
  EXPECT_TRUE(history.Increment({0}, {1500000}));
  EXPECT_FALSE(history.Increment({500000}, {400000}));
}

TEST(DrHistory, NeverBridgesAReset) {
  const DrHistory history = StraightDrive(101, 50);
  EXPECT_TRUE(history.Increment({0}, {480000}));
  EXPECT_TRUE(history.Increment({510000}, {1000000}));
  EXPECT_FALSE(history.Increment({480000}, {510000}));
  EXPECT_FALSE(history.PoseAt({495000}));
}

TEST(DrHistory, RefusesTimeThatDoesNotIncrease) {
  DrHistory history = StraightDrive(2);
  DrState s;
  s.utime = {10000};
  EXPECT_FALSE(history.Push(s));
}

// White noise grows with time, coherent noise with its square; rotation noise reaches position
// through the lever: for white yaw noise w over a way L driven in time t, var(y) = w t L^2 / 3.
TEST(DrHistory, CovarianceComposesWhiteAndCoherentParts) {
  DrHistory history;
  for (int i = 0; i <= 1000; ++i) {
    DrState s;
    s.utime = {i * 1000};
    s.T_OB = SE3(Eigen::Quaterniond::Identity(), {2e-3 * i, 0, 0});
    s.cov_twist_white(0, 0) = 0.5;
    s.cov_twist_white(5, 5) = 0.01;
    s.cov_twist_coherent(1, 1) = 0.09;
    history.Push(s);
  }
  const auto increment = history.Increment({0}, {1000000});
  ASSERT_TRUE(increment);
  EXPECT_NEAR(increment->cov(0, 0), 0.5, 1e-9);
  EXPECT_NEAR(increment->cov(5, 5), 0.01, 1e-9);
  EXPECT_NEAR(increment->cov(1, 1), 0.09 + 0.01 * 4.0 / 3.0, 1e-4);
}

// Turns by 1 rad within a second and back within the next, on the spot.
DrHistory ThereAndBack(double sigma_there, double sigma_back) {
  DrHistory history;
  for (int i = 0; i <= 200; ++i) {
    DrState s;
    s.utime = {i * 10000};
    s.T_OB = SE3(ExpSO3({0, 0, 0.01 * (i <= 100 ? i : 200 - i)}), Eigen::Vector3d::Zero());
    s.w_OB_B = {0, 0, i <= 100 ? 1.0 : -1.0};
    s.turn_scale_sigma = i <= 100 ? sigma_there : sigma_back;
    history.Push(s);
  }
  return history;
}

double HeadingVariance(const DrHistory& history) {
  DrNoise noise;
  const auto increment = history.Increment({0}, {2000000}, &noise);
  EXPECT_LT((increment->cov - noise.Covariance()).norm(), 1e-15);
  return increment->cov(5, 5);
}

TEST(DrHistory, AWrongScaleCancelsOnTheWayBack) {
  EXPECT_NEAR(HeadingVariance(ThereAndBack(0.01, 0.01)), 0, 1e-12);
}

// The scale's error e0 of the way there is that of the way back, e1, and what was learnt in
// between, independent of e1: e0 - e1 has the variance sigma0^2 - sigma1^2.
TEST(DrHistory, WhatIsLearntInBetweenCorrectsTheWayBackAlone) {
  const double learnt = 0.01 * 0.01 - 0.008 * 0.008;
  EXPECT_NEAR(HeadingVariance(ThereAndBack(0.01, 0.008)), learnt, 1e-9);
  EXPECT_NEAR(HeadingVariance(ThereAndBack(0.008, 0.01)), learnt, 1e-9) << "a scale that wanders";
}

TEST(DrHistory, StandingStillForgetsNothing) {
  DrHistory history;
  for (int i = 0; i <= 300; ++i) {  // 1 s at 0.1 rad/s, still for 1 s, 1 s more
    DrState s;
    s.utime = {i * 10000};
    const bool still = i > 100 && i <= 200;
    const double turned = 0.001 * (i <= 100 ? i : std::max(100, i - 100));
    s.T_OB = SE3(ExpSO3({0, 0, turned}), Eigen::Vector3d::Zero());
    if (!still) s.cov_twist_coherent(5, 5) = 1e-4;
    history.Push(s);
  }
  const auto increment = history.Increment({0}, {3000000});
  ASSERT_TRUE(increment);
  EXPECT_NEAR(increment->cov(5, 5), 4e-4, 1e-8) << "the same bias before and after";
}

// What a robot does between two states is in the noise: nothing at a state, most in the middle, and
// more beyond the newest.
TEST(DrHistory, TheWayBetweenStatesIsNotKnown) {
  DrHistory history;
  for (int i = 0; i <= 10; ++i) {
    DrState s;
    s.utime = {i * 200'000};
    s.T_OB = SE3(Eigen::Quaterniond::Identity(), {0.1 * i, 0, 0});
    s.v_OB_B = {0.5, 0, 0};
    EXPECT_TRUE(history.Push(s));
  }
  const auto sigma = [&](int64_t a, int64_t b) {
    return std::sqrt(history.Increment({a}, {b})->cov(0, 0));
  };
  EXPECT_EQ(sigma(0, 2'000'000), 0);
  EXPECT_NEAR(sigma(0, 1'900'000), 0.5 * 0.1 * 0.1 / 2, 1e-12);
  EXPECT_NEAR(sigma(900'000, 1'000'000), 0.5 * 0.1 * 0.1 / 2, 1e-12);
  EXPECT_NEAR(sigma(0, 2'200'000), 0.5 * 0.2 * 0.2 / 2, 1e-12);
  EXPECT_GT(history.Increment({0}, {2'200'000})->cov(5, 5), 0);
}

}  // namespace
}  // namespace gw

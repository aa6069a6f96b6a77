#include "common/contract/dr_history.h"

#include <gtest/gtest.h>

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
  const auto increment = history.Increment({123456}, {654321}, {0});
  ASSERT_TRUE(increment);
  EXPECT_NEAR(increment->T_BaBb.translation().x(), 0.530865, 1e-9);
}

TEST(DrHistory, RefusesWhatItDoesNotCover) {
  const DrHistory history = StraightDrive(101);
  EXPECT_FALSE(history.Increment({-1}, {100}, {0}));
  EXPECT_FALSE(history.Increment({0}, {1000001}, {0}));
  EXPECT_TRUE(history.Increment({0}, {1005000}, {10000}));
  EXPECT_FALSE(history.Increment({500000}, {400000}, {0}));
}

TEST(DrHistory, NeverBridgesAReset) {
  const DrHistory history = StraightDrive(101, 50);
  EXPECT_TRUE(history.Increment({0}, {480000}, {0}));
  EXPECT_TRUE(history.Increment({510000}, {1000000}, {0}));
  EXPECT_FALSE(history.Increment({480000}, {510000}, {0}));
  EXPECT_FALSE(history.PoseAt({495000}, {0}));
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
  const auto increment = history.Increment({0}, {1000000}, {0});
  ASSERT_TRUE(increment);
  EXPECT_NEAR(increment->cov(0, 0), 0.5, 1e-9);
  EXPECT_NEAR(increment->cov(5, 5), 0.01, 1e-9);
  EXPECT_NEAR(increment->cov(1, 1), 0.09 + 0.01 * 4.0 / 3.0, 1e-4);
}

}  // namespace
}  // namespace gw

#include "frontend/core/motion/motion_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gw::frontend {
namespace {

constexpr int64_t kImageUs = 100'000;
constexpr int64_t kWheelUs = 200'000;

// Wheels without an IMU, five times a second, of a robot that starts, turns and stops all the time;
// images twice as often.
class SlowWheels : public testing::Test {
 protected:
  static SE3 Truth(int64_t us) {
    const double t = 1e-6 * static_cast<double>(us);
    return SE3(ExpSO3({0, 0, 0.6 * std::sin(2.2 * t)}), {0.3 * t - 0.1 * std::sin(3 * t), 0, 0});
  }

  void Wheel(int64_t us, uint32_t reset_counter = 0) {
    DrState s;
    s.utime = {us};
    s.T_OB = Truth(us);
    Vector6d twist = (Truth(us - kWheelUs).inverse() * Truth(us)).Log() / (1e-6 * kWheelUs);
    s.v_OB_B = twist.head<3>();
    s.w_OB_B = twist.tail<3>();
    s.reset_counter = reset_counter;
    EXPECT_TRUE(motion_.Push(s));
  }

  // The image, after the wheels that are there by then, goes without vision.
  void Image(int64_t us) {
    const Motion motion = motion_.Between({us - kImageUs}, {us});
    motion_.GoOn({us - kImageUs}, {us}, motion);
    T_WC_ = T_WC_ * motion.T_ab;
    from_dr_ += motion.from_dr ? 1 : 0;
  }

  // What the way has in error: with T_BC the identity, camera and body are one.
  double Error(int64_t from, int64_t to) const {
    return (T_WC_.inverse() * (Truth(from).inverse() * Truth(to))).Log().norm();
  }

  static FrontendConfig Config() {
    FrontendConfig config;
    config.variant = Variant::kFull;
    return config;
  }

  MotionModel motion_{RectifiedCamera(), ImuCalibration(), Config()};
  SE3 T_WC_;
  int from_dr_ = 0;
};

TEST_F(SlowWheels, NoWayIsLostInTheDark) {
  Wheel(0);
  for (int64_t us = kImageUs; us <= 10'000'000; us += kImageUs) {
    if (us % kWheelUs == 0) Wheel(us);
    Image(us);
  }
  EXPECT_EQ(from_dr_, 100) << "a pose for every image";
  EXPECT_LT(Error(0, 10'000'000), 1e-9);
}

TEST_F(SlowWheels, EdgesAddUpToTheWay) {
  Wheel(0);
  SE3 T_sum;
  Utime last{0};
  for (int64_t us = kImageUs; us <= 10'000'000; us += kImageUs) {
    if (us % kWheelUs == 0) Wheel(us);
    Image(us);
    if (us % 500'000 != 0) continue;  // a keyframe, every second time between two wheels
    const auto edge = motion_.Increment(last, {us});
    ASSERT_TRUE(edge);
    T_sum = T_sum * edge->T_BaBb;
    last = {us};
  }
  EXPECT_LT((T_sum.inverse() * (Truth(0).inverse() * Truth(10'000'000))).Log().norm(), 1e-9);
}

TEST_F(SlowWheels, WhatWasDrivenInSilenceIsMadeUpFor) {
  Wheel(0);
  for (int64_t us = kImageUs; us <= 10'000'000; us += kImageUs) {
    const bool silent = us > 3'000'000 && us < 7'000'000;
    if (us % kWheelUs == 0 && !silent) Wheel(us);
    Image(us);
  }
  EXPECT_LT(from_dr_, 70) << "silence is noticed";
  EXPECT_LT(Error(0, 10'000'000), 1e-9);
}

TEST_F(SlowWheels, AResetIsNotBridged) {
  Wheel(0);
  for (int64_t us = kImageUs; us <= 2'000'000; us += kImageUs) {
    if (us % kWheelUs == 0) Wheel(us, us > 1'000'000 ? 1 : 0);
    Image(us);
  }
  EXPECT_GE(from_dr_, 17);
  EXPECT_LT(from_dr_, 20);
}

// Seconds in which dead reckoning says that its wheels slip, and goes astray by 0.2 m/s, now to one
// side and now to the other; sigma: of its twist, as it claims. True when it is trusted in the end.
bool IsTrusted(double sigma_m_s) {
  FrontendConfig config;
  config.variant = Variant::kFull;
  MotionModel motion{RectifiedCamera(), ImuCalibration(), config};
  constexpr int64_t kStateUs = 50'000, kSlipUs = 8'000'000;
  const auto truth = [](int64_t us) {
    return SE3(Eigen::Quaterniond(1, 0, 0, 0), {5e-7 * us, 0, 0});
  };
  SE3 T_OB;
  for (int64_t us = 0; us <= 16'000'000; us += kStateUs) {
    DrState s;
    s.slip = us > kSlipUs;
    const double astray = s.slip ? ((us / 700'000) % 2 == 0 ? 0.2 : -0.3) : 0;
    const double dt = 1e-6 * kStateUs;
    s.utime = {us};
    s.v_OB_B = {0.5, astray, 0};
    if (us > 0) T_OB = T_OB * SE3(Eigen::Quaterniond::Identity(), dt * s.v_OB_B);
    s.T_OB = T_OB;
    s.cov_twist_white = 1e-6 * Matrix6d::Identity();
    s.cov_twist_coherent.diagonal().head<3>().setConstant(s.slip ? sigma_m_s * sigma_m_s : 1e-6);
    s.wheels_alive = true;
    EXPECT_TRUE(motion.Push(s));
    if (us % kImageUs != 0 || us == 0) continue;
    MotionModel::Seen seen;
    seen.a = {us - kImageUs};
    seen.b = {us};
    seen.T_ab = truth(us - kImageUs).inverse() * truth(us);
    seen.healthy = seen.sure = true;
    seen.T_WC_vision = truth(us);
    seen.cov_vision = 1e-6 * Matrix6d::Identity();
    motion.Observe(seen, motion.Between(seen.a, seen.b));
  }
  return motion.dr_trusted();
}

TEST(MotionModel, SlipIsNoExcuseForClaimsThatDoNotHold) {
  EXPECT_FALSE(IsTrusted(0.005));
  EXPECT_TRUE(IsTrusted(0.3));
}

}  // namespace
}  // namespace gw::frontend

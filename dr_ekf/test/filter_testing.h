// What the tests of the filter have in common.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "dr_ekf/core/dr_filter.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {

inline DrFilter Make(const Calibration& calibration, const DrEkfConfig& config = {}) {
  Result<DrFilter> filter = DrFilter::Create(config, calibration);
  EXPECT_TRUE(filter.ok());
  return std::move(filter).value();
}

// The body's pose in the frame that it had at the begin.
inline SE3 TruthFromStart(const Recording& r, Utime t) {
  return r.T_GB.front().inverse() * r.TruthAt(t);
}

// Bit by bit, but for the count of publications.
inline void ExpectIdentical(const DrState& a, const DrState& b) {
  EXPECT_EQ(a.utime, b.utime);
  EXPECT_EQ(a.T_OB.translation(), b.T_OB.translation());
  EXPECT_EQ(a.T_OB.rotation().coeffs(), b.T_OB.rotation().coeffs());
  EXPECT_EQ(a.v_OB_B, b.v_OB_B);
  EXPECT_EQ(a.w_OB_B, b.w_OB_B);
  EXPECT_EQ(a.gyro_bias_rad_s, b.gyro_bias_rad_s);
  EXPECT_EQ(a.accel_bias_m_s2, b.accel_bias_m_s2);
  EXPECT_EQ(a.wheel_scale, b.wheel_scale);
  EXPECT_EQ(a.cov_T_OB, b.cov_T_OB);
  EXPECT_EQ(a.cov_twist_white, b.cov_twist_white);
  EXPECT_EQ(a.cov_twist_coherent, b.cov_twist_coherent);
  EXPECT_EQ(a.way_scale_sigma, b.way_scale_sigma);
  EXPECT_EQ(a.turn_scale_sigma, b.turn_scale_sigma);
}

}  // namespace gw::dr_ekf

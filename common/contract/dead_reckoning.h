// What the dead-reckoning (DR) filter tells the others.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw {

// State of the DR filter at one instant, published at the rate of its fastest input.
//
// T_OB is continuous within one value of reset_counter. The covariance of the relative motion over
// an interval (a, b] cannot be had from two marginal covariances; the filter therefore publishes
// how it grows, in B, from which DrHistory::Increment composes it (Ad = Ad(T_BbBt), t in (a, b]):
//   cov(T_BaBb) = int Ad W Ad^T dt + L C L^T + (sigma_way l_w) (.)^T + (sigma_turn l_t) (.)^T
//   L = int Ad dt,   l_w = int Ad [v; 0] dt,   l_t = int Ad [0; w] dt
// W (white) is noise that averages out; C (coherent) is a twist error that stays constant over
// seconds: bias; the errors of the two scales stay constant as well, but what they do goes with the
// motion: a turn there and back cancels them (docs/adr/0004-dr-increment-covariance.md). Where C or
// a sigma changes inside the interval, L and l hold only what the errors of then and of the end
// have in common (DrNoise).
struct DrState {
  Utime utime;
  int64_t seq = 0;
  uint32_t reset_counter = 0;  // moves on when T_OB is not continuous with the state before
  SE3 T_OB;
  Eigen::Vector3d v_OB_B = Eigen::Vector3d::Zero();  // m/s, of B in O, expressed in B
  Eigen::Vector3d w_OB_B = Eigen::Vector3d::Zero();  // rad/s
  Eigen::Vector3d gyro_bias_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_m_s2 = Eigen::Vector3d::Zero();
  double wheel_scale = 1.0;                        // true way / measured way
  double turn_scale = 1.0;                         // likewise of the sensor that tells turns now
  Matrix6d cov_T_OB = Matrix6d::Zero();            // m^2, rad^2; grows without bound
  Matrix6d cov_twist_white = Matrix6d::Zero();     // W: m^2/s, rad^2/s
  Matrix6d cov_twist_coherent = Matrix6d::Zero();  // C: (m/s)^2, (rad/s)^2
  double way_scale_sigma = 0;                      // sigma_way: of true way / way told here
  double turn_scale_sigma = 0;                     // sigma_turn: of true turn / turn told here
  bool gravity_aligned = false;  // roll and pitch of T_OB are absolute (accelerometer)
  bool slip = false;             // wheels disagree with gyro or vision
  bool stationary = false;       // zero-velocity update active
  bool wheels_alive = false;
  bool imu_alive = false;
  bool synthetic = false;  // made from ground truth by an importer, not measured
};

// Height of the body in O at one instant.
struct DrHeight {
  double z = 0;                // m
  double variance = 0;         // m^2, > 0
  uint32_t reset_counter = 0;  // of the O that it is in (DrState)
};

// Relative motion of the body between two instants.
struct DrIncrement {
  Utime utime_begin;
  Utime utime_end;
  SE3 T_BaBb;
  Matrix6d cov = Matrix6d::Zero();  // right perturbation of T_BaBb
  uint32_t reset_counter = 0;
  bool slip = false;  // slip was flagged somewhere in the interval
  bool synthetic = false;
};

// The pose for control: T_WO * T_OB, at DR rate. Corrections of T_WO are made at a bounded rate
// (section `dr_ekf` of the configuration); the covariance holds what of them is outstanding.
struct Pose {
  Utime utime;
  int64_t seq = 0;
  SE3 T_WB;
  Matrix6d cov_T_WB = Matrix6d::Zero();
  Eigen::Vector3d v_WB_B = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_WB_B = Eigen::Vector3d::Zero();
  SE3 T_WO;
  Matrix6d cov_T_WO = Matrix6d::Zero();
  bool has_map = false;           // false: no place in the map yet, W is O
  int64_t frame_pose_age_us = 0;  // since the image of the newest FRAME_POSE used
  int64_t frame_pose_seq = 0;
  int64_t map_revision = 0;
  int64_t dr_seq = 0;
  uint32_t dr_reset_counter = 0;
  uint32_t reset_counter = 0;  // moves on when T_WB is not continuous with the pose before

  // A position that is less certain than this (1 sigma, m) claims no place in the map.
  static constexpr double kClaimSigma = 1.0;
  bool ClaimsPlace() const {
    return cov_T_WB.diagonal().head<3>().maxCoeff() < kClaimSigma * kClaimSigma;
  }
};

}  // namespace gw

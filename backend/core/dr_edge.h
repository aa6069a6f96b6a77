// Dead reckoning as an edge between two camera poses.
//
// This is the one place of the back-end where DR changes from the body to the camera frame.
#pragma once

#include "common/config/frontend_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/core/se3.h"

namespace gw::backend {

struct DrMotion {
  SE3 T_CaCb;    // camera at the end in the camera at the beginning
  Matrix6d cov;  // right perturbation of T_CaCb; m^2, rad^2; positive definite
};

// T_CaCb = inv(T_BC) * T_BaBb * T_BC. The covariance is the larger, in every direction, of
//  - the nominal one: diag(sigma_t^2, sigma_r^2) for each 1/30 s of the interval (method.md 2), at
//    least one;
//  - the filter's own, carried along: T_CaCb * Exp(Ad(inv(T_BC)) d) = inv(T_BC) T_BaBb Exp(d) T_BC.
// Precondition: IsUsable(dr, dr.utime_end).
DrMotion CameraMotion(const DrIncrement& dr, const SE3& T_BC, const DrWeightConfig& config);

// The smallest covariance that is not below `a` nor `b` along the axes in which both are diagonal
// (their joint eigenvectors). Precondition: a is positive definite, b symmetric.
Matrix6d LargerCovariance(const Matrix6d& a, const Matrix6d& b);

// Upper triangular S with S^T S = alpha * inv(cov). Precondition: cov is positive definite, alpha >
// 0.
Matrix6d SqrtInformation(const Matrix6d& cov, double alpha);

}  // namespace gw::backend

// Dead reckoning as an edge between two camera poses.
//
// This is the one place of the back-end where DR changes from the body to the camera frame.
#pragma once

#include "common/config/frontend_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/core/se3.h"

namespace gw::backend {

struct DrMotion {
  SE3 T_CaCb;             // camera at the end in the camera at the beginning
  Matrix6d cov;           // right perturbation of T_CaCb; m^2, rad^2; positive definite
  Matrix6d reported_cov;  // the filter's own part in it; may be zero
};

// T_CaCb = inv(T_BC) * T_BaBb * T_BC. The covariance is the larger, in every direction, of
//  - the nominal one: diag(sigma_t^2, sigma_r^2) for each 1/30 s of the interval (method.md 2), at
//    least one;
//  - the filter's own, carried along: T_CaCb * Exp(Ad(inv(T_BC)) d) = inv(T_BC) T_BaBb Exp(d) T_BC.
// Precondition: IsUsable(dr, dr.utime_end).
DrMotion CameraMotion(const DrIncrement& dr, const SE3& T_BC, const DrWeightConfig& config);

// Covariance of an edge that counts with the scale alpha > 0: cov / alpha. Where alpha follows the
// quality of tracking, it is not below what the filter says of itself: blind vision is no reason to
// believe dead reckoning more than it does (docs/adr/0012-no-more-than-dr-knows.md).
Matrix6d EdgeCovariance(const DrMotion& motion, double alpha, Variant variant);

// Upper triangular S with S^T S = inv(cov). Precondition: cov is positive definite.
Matrix6d SqrtInformation(const Matrix6d& cov);

}  // namespace gw::backend

// Dead reckoning as an edge between two camera poses.
//
// This is the one place of the back-end where DR changes from the body to the camera frame.
#pragma once

#include "common/config/frontend_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/core/se3.h"

namespace gw::backend {

// How a motion changes with errors of the two scales of dead reckoning, as a right perturbation per
// unit: column 0 where the way is longer than told, column 1 where the turn is. To first order:
// scales are off by about 1 %.
using ScaleLever = Eigen::Matrix<double, 6, 2>;

struct DrMotion {
  SE3 T_CaCb;             // camera at the end in the camera at the beginning
  ScaleLever lever;       // of the scales of the body's way and turn on T_CaCb
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

// How much larger the errors of poses from vision are than independent errors of the features would
// make them: neighbouring images see the same landmarks in the same wrong places. Measured image by
// image, along the way and in heading (VisionInflation in
// frontend/core/motion/pose_uncertainty.cc: 2.1, 3.2 and 1.8; their root mean square).
inline constexpr double kVisionInflation = 2.4;

// Covariance of an edge in a bundle adjustment of the whole map, for sightings that count as if
// their errors were independent. Over a lap they are not, and what alpha says of one image is no
// measure of it: where alpha follows the quality of tracking and the filter reports a covariance,
// the way of dead reckoning counts for all it knows (as for a blind image), and as much more as the
// sightings count too much. Its turn counts as in local BA: the errors of headings that follow each
// other are one bias, which edges that are independent of each other would take for knowledge
// (docs/adr/0015-dead-reckoning-in-global-ba.md).
Matrix6d WholeMapEdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                                const DrWeightConfig& config);

// Upper triangular S with S^T S = inv(cov). Precondition: cov is positive definite.
Matrix6d SqrtInformation(const Matrix6d& cov);

}  // namespace gw::backend

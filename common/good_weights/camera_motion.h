// Dead reckoning (DR) as a motion of the camera: the one place where it changes from the axes of
// the body B to those of the camera C (docs/method.md, section 1.2).
//
// An error d on the right of T_BaBb is Ad(inv(T_BC)) d on the right of T_CaCb, since
// T_CaCb Exp(Ad(inv(T_BC)) d) = inv(T_BC) T_BaBb Exp(d) T_BC.
#pragma once

#include "common/config/dr_weight_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/core/se3.h"
#include "common/good_weights/dr_history.h"

namespace gw {

// inv(T_BC) T_BaBb T_BC.
SE3 InCamera(const SE3& T_BaBb, const SE3& T_BC);
// The noise of T_BaBb as that of T_CaCb.
DrNoise InCamera(const DrNoise& noise, const SE3& T_BC);
Matrix6d InCamera(const Matrix6d& cov, const SE3& T_BC);

// How a motion changes with errors of the two scales of dead reckoning, as a right perturbation per
// unit: column 0 where the way is longer than told, column 1 where the turn is. To first order:
// scales are off by about 1 %.
using ScaleLever = Eigen::Matrix<double, 6, 2>;

// The motion of the camera between two keyframes.
struct DrMotion {
  SE3 T_CaCb;             // camera at the end in the camera at the beginning
  ScaleLever lever;       // of the scales of the body's way and turn on T_CaCb
  Matrix6d cov;           // Sigma_d (DrCovariance): m^2, rad^2; positive definite
  Matrix6d reported_cov;  // the filter's own part in it; may be zero
};

// Precondition: dr covers a time > 0 and is finite.
DrMotion CameraMotion(const DrIncrement& dr, const SE3& T_BC, const DrWeightConfig& config);

}  // namespace gw

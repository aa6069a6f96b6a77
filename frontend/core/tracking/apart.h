// When two estimates of a pose contradict each other.
#pragma once

#include <Eigen/Cholesky>

#include "common/core/se3.h"
#include "common/good_weights/edge_covariance.h"

namespace gw::frontend {

// They are not of one pose, or their covariances are far too small (chi-square, 99.9 %). cov: of
// their difference, right perturbation.
inline bool Apart(const SE3& a, const SE3& b, const Matrix6d& cov) {
  const Vector6d e = (a.inverse() * b).Log();
  return e.dot(cov.ldlt().solve(e)) > kDrRadius2;
}

}  // namespace gw::frontend

// Comparing covariances of six-dimensional errors.
#pragma once

#include "common/core/se3.h"

namespace gw {

// The smallest covariance that is not below `a` nor `b` along the axes in which both are diagonal
// (their joint eigenvectors). Precondition: a is positive definite, b symmetric.
Matrix6d LargerCovariance(const Matrix6d& a, const Matrix6d& b);

}  // namespace gw

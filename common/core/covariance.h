// Covariances of six-dimensional errors: compared, and as square roots of their information.
#pragma once

#include "common/core/se3.h"

namespace gw {

// The smallest covariance that is not below `a` nor `b` along the axes in which both are diagonal
// (their joint eigenvectors). Precondition: a is positive definite, b symmetric.
Matrix6d LargerCovariance(const Matrix6d& a, const Matrix6d& b);

// Upper triangular S with S^T S = inv(cov). Precondition: cov is positive definite.
Matrix6d SqrtInformation(const Matrix6d& cov);

}  // namespace gw

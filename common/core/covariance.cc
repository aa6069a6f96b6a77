#include "common/core/covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace gw {

Matrix6d LargerCovariance(const Matrix6d& a, const Matrix6d& b) {
  const Eigen::LLT<Matrix6d> llt(a);
  const Matrix6d L = llt.matrixL();
  const Matrix6d Li = L.triangularView<Eigen::Lower>().solve(Matrix6d::Identity());
  // In the coordinates where `a` is the identity, b = U S U^T; the larger one is U max(S, 1) U^T.
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(Li * b * Li.transpose());
  const Vector6d larger = eigen.eigenvalues().cwiseMax(1.0);
  const Matrix6d LU = L * eigen.eigenvectors();
  return LU * larger.asDiagonal() * LU.transpose();
}

Matrix6d SqrtInformation(const Matrix6d& cov) {
  const Matrix6d information = Eigen::LLT<Matrix6d>(cov).solve(Matrix6d::Identity());
  return Eigen::LLT<Matrix6d>(0.5 * (information + information.transpose())).matrixU();
}

}  // namespace gw

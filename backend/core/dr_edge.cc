#include "backend/core/dr_edge.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>

namespace gw::backend {

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

DrMotion CameraMotion(const DrIncrement& dr, const SE3& T_BC, const DrWeightConfig& config) {
  const SE3 T_CB = T_BC.inverse();
  DrMotion out;
  out.T_CaCb = T_CB * dr.T_BaBb * T_BC;
  const double periods = std::max(1.0, (dr.utime_end - dr.utime_begin).seconds() * 30.0);
  const double sigma_t = config.sigma_trans_m_per_frame;
  const double sigma_r = config.sigma_rot_deg_per_frame * std::numbers::pi / 180.0;
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(sigma_t * sigma_t),
      Eigen::Vector3d::Constant(sigma_r * sigma_r);
  const Matrix6d nominal = (periods * variance).asDiagonal();
  const Matrix6d adj = T_CB.Adjoint();
  out.cov = LargerCovariance(nominal, adj * dr.cov * adj.transpose());
  return out;
}

Matrix6d SqrtInformation(const Matrix6d& cov, double alpha) {
  const Eigen::LLT<Matrix6d> llt(cov);
  const Matrix6d information = alpha * llt.solve(Matrix6d::Identity());
  return Eigen::LLT<Matrix6d>(0.5 * (information + information.transpose())).matrixU();
}

}  // namespace gw::backend

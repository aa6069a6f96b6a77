#include "backend/core/bundle/dr_edge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numbers>

#include "common/core/covariance.h"

namespace gw::backend {

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
  out.lever.setZero();
  out.lever.col(0).head<3>() = dr.T_BaBb.rotation().conjugate() * dr.T_BaBb.translation();
  out.lever.col(1).tail<3>() = LogSO3(dr.T_BaBb.rotation());
  out.lever = (adj * out.lever).eval();
  out.reported_cov = adj * dr.cov * adj.transpose();
  out.cov = LargerCovariance(nominal, out.reported_cov);
  return out;
}

Matrix6d EdgeCovariance(const DrMotion& motion, double alpha, Variant variant) {
  const Matrix6d scaled = motion.cov / alpha;
  return AdaptsAlpha(variant) ? LargerCovariance(scaled, motion.reported_cov) : scaled;
}

Matrix6d WholeMapEdgeCovariance(const DrMotion& motion, double alpha, Variant variant,
                                const DrWeightConfig& config) {
  const Matrix6d local = EdgeCovariance(motion, alpha, variant);
  if (!AdaptsAlpha(variant) || motion.reported_cov.isZero(0)) return local;
  const Matrix6d known = EdgeCovariance(motion, config.alpha_max, variant);
  Matrix6d information = local.inverse();
  information.topLeftCorner<3, 3>() +=
      kVisionInflation * kVisionInflation * known.topLeftCorner<3, 3>().inverse();
  return information.inverse();
}

Matrix6d SqrtInformation(const Matrix6d& cov) {
  const Matrix6d information = Eigen::LLT<Matrix6d>(cov).solve(Matrix6d::Identity());
  return Eigen::LLT<Matrix6d>(0.5 * (information + information.transpose())).matrixU();
}

}  // namespace gw::backend

#include "common/good_weights/camera_motion.h"

#include "common/good_weights/covariance.h"

namespace gw {

SE3 InCamera(const SE3& T_BaBb, const SE3& T_BC) {
  return T_BC.inverse() * T_BaBb * T_BC;
}

DrNoise InCamera(const DrNoise& noise, const SE3& T_BC) {
  const Matrix6d adj = T_BC.inverse().Adjoint();
  DrNoise out = noise;
  out.white = adj * noise.white * adj.transpose();
  out.lever = adj * noise.lever;
  return out;
}

Matrix6d InCamera(const Matrix6d& cov, const SE3& T_BC) {
  const Matrix6d adj = T_BC.inverse().Adjoint();
  return adj * cov * adj.transpose();
}

DrMotion CameraMotion(const DrIncrement& dr, const SE3& T_BC, const DrWeightConfig& config) {
  DrMotion out;
  out.T_CaCb = InCamera(dr.T_BaBb, T_BC);
  out.lever.setZero();
  out.lever.col(0).head<3>() = dr.T_BaBb.rotation().conjugate() * dr.T_BaBb.translation();
  out.lever.col(1).tail<3>() = LogSO3(dr.T_BaBb.rotation());
  out.lever = (T_BC.inverse().Adjoint() * out.lever).eval();
  out.reported_cov = InCamera(dr.cov, T_BC);
  out.cov = InCamera(DrCovariance(dr.utime_end - dr.utime_begin, dr.cov, config), T_BC);
  return out;
}

}  // namespace gw

#include "frontend/core/pose_uncertainty.h"

#include <Eigen/Cholesky>

namespace gw::frontend {
namespace {

// Sigma of the visual estimate, as a multiple of what the inverse of its information says, camera
// axes. Above one because the errors of an image's landmarks are not independent of each other:
// they were placed from few views, most of all along the optical axis. Below one where many
// landmarks at the image's rim over-determine the angle. Measured on simulated drives (stereo), in
// docs/results.md, consistency.
Vector6d VisionInflation() {
  Vector6d scale;
  scale << 2.1, 1.4, 3.2, 1.1, 1.8, 1.0;
  return scale;
}

Matrix6d Inflated(const Matrix6d& cov) {
  const Vector6d scale = VisionInflation();
  return scale.asDiagonal() * (0.5 * (cov + cov.transpose())) * scale.asDiagonal();
}

}  // namespace

Matrix6d VisionCovariance(const Matrix6d& vision_information) {
  return Inflated(vision_information.ldlt().solve(Matrix6d::Identity()));
}

void PoseUncertainty::Reset(const Matrix6d& cov) {
  cov_ = cov;
  cross_.setZero();
}

void PoseUncertainty::Predict(const SE3& T_ab, const DrNoise& noise) {
  const Matrix6d A = T_ab.inverse().Adjoint();
  const Matrix6d& G = noise.lever;
  const Matrix6d AxG = A * cross_ * G.transpose();
  cov_ = A * cov_ * A.transpose() + AxG + AxG.transpose() + noise.Covariance();
  cross_ = A * cross_ + G * noise.coherent;
}

void PoseUncertainty::Update(const Matrix6d& vision_information,
                             const Matrix6d& prior_information) {
  const Eigen::LDLT<Matrix6d> hessian(vision_information + prior_information);
  const Matrix6d K = hessian.solve(vision_information);
  const Matrix6d L = Matrix6d::Identity() - K;
  cov_ = L * cov_ * L.transpose() + Inflated(K * hessian.solve(Matrix6d::Identity()));
  cross_ = L * cross_;
}

}  // namespace gw::frontend

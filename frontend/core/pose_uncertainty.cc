#include "frontend/core/pose_uncertainty.h"

#include <Eigen/Cholesky>

namespace gw::frontend {
namespace {

// Covariance of the visual estimate, as a multiple of the inverse of its information. Above one
// because the errors of an image's landmarks are not independent of each other: they were placed
// from few views. Measured: see docs/results.md, consistency.
constexpr double kVisionInflation = 4.0;

}  // namespace

Matrix6d VisionCovariance(const Matrix6d& vision_information) {
  return kVisionInflation * vision_information.ldlt().solve(Matrix6d::Identity());
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
  const Matrix6d vision = kVisionInflation * K * hessian.solve(Matrix6d::Identity());
  cov_ = L * cov_ * L.transpose() + 0.5 * (vision + vision.transpose());
  cross_ = L * cross_;
}

}  // namespace gw::frontend

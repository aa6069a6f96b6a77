#include "frontend/core/motion/pose_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdlib>

#include "common/good_weights/vision_noise.h"

namespace gw::frontend {
namespace {

// Symmetric; directions without variance have none.
Matrix6d Root(const Matrix6d& cov) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(cov);
  const Matrix6d& axes = solver.eigenvectors();
  return axes * solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * axes.transpose();
}

}  // namespace

void PoseUncertainty::Reset(const Matrix6d& cov) {
  cov_ = cov;
  cross_.setZero();
  with_vision_.setZero();
  for (Past& a : past_) {
    a.cross.setZero();
    a.with_now.setZero();
    a.with_vision.setZero();
  }
}

void PoseUncertainty::Predict(const SE3& T_ab, const DrNoise& noise, DurationUs time) {
  const Matrix6d A = T_ab.inverse().Adjoint();
  const DrLever& G = noise.lever;
  cross_ = (cross_ * noise.kept.asDiagonal()).eval();  // with c as it is now
  const Matrix6d with_common = A * cross_ * G.transpose();
  cov_ = A * cov_ * A.transpose() + with_common + with_common.transpose() + noise.Covariance();
  cross_ = (A * cross_ + G * noise.coherent).eval();
  const double kept = std::exp(-time.seconds() / kVisionMemory);
  with_vision_ = (kept * A * with_vision_).eval();
  for (Past& a : past_) {
    a.cross = (a.cross * noise.kept.asDiagonal()).eval();
    a.with_now = (A * a.with_now + G * a.cross.transpose()).eval();
    a.with_vision *= kept;
    a.shift = (A * a.shift).eval();
  }
}

void PoseUncertainty::Update(const Matrix6d& vision_information,
                             const Matrix6d& prior_information) {
  const Eigen::LDLT<Matrix6d> hessian(vision_information + prior_information);
  const Matrix6d K = hessian.solve(vision_information);
  const Matrix6d L = Matrix6d::Identity() - K;
  const Matrix6d pull_cov = Inflated(K * hessian.solve(Matrix6d::Identity()));
  const Matrix6d B = Root(pull_cov);
  const Matrix6d with_pull = L * with_vision_ * B.transpose();
  cov_ = L * cov_ * L.transpose() + pull_cov + with_pull + with_pull.transpose();
  cross_ = (L * cross_).eval();
  with_vision_ = (L * with_vision_ + B).eval();
  for (Past& a : past_) a.with_now = (L * a.with_now + B * a.with_vision.transpose()).eval();
}

void PoseUncertainty::Shift(const Vector6d& shift) {
  for (Past& a : past_) a.shift += shift;
}

std::optional<PoseUncertainty::Motion> PoseUncertainty::Remember(Utime utime, const SE3& T_WC,
                                                                 DurationUs span) {
  const auto distance = [&](const Past& a) { return std::abs((utime - a.utime - span).us); };
  while (past_.size() > 1 && distance(past_[1]) <= distance(past_[0])) past_.pop_front();
  std::optional<Motion> motion;
  if (!past_.empty() && distance(past_.front()) <= kSpanTolerance.us) {
    const Past& a = past_.front();
    const Matrix6d adj = (T_WC.inverse() * a.T_WC).Adjoint();
    const Matrix6d shared = adj * a.with_now.transpose();
    const Matrix6d cov = cov_ + adj * a.cov * adj.transpose() - shared - shared.transpose() +
                         a.shift * a.shift.transpose();
    motion = Motion{utime - a.utime, 0.5 * (cov + cov.transpose())};
  }
  past_.push_back({utime, T_WC, cov_, cross_, cov_, with_vision_, Vector6d::Zero()});
  return motion;
}

}  // namespace gw::frontend

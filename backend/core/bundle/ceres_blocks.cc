#include "backend/core/bundle/ceres_blocks.h"

#include <algorithm>
#include <cmath>

#include "common/core/robust_loss.h"

namespace gw::backend {
namespace {

using RowMajor67 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;

// d(tangent of inv(x) * y) / dy at y = x: the tangent that belongs to a change of the block.
RowMajor67 TangentOfBlock(const Eigen::Quaterniond& q) {
  RowMajor67 J = RowMajor67::Zero();
  J.topRightCorner<3, 3>() = q.toRotationMatrix().transpose();
  J.block<3, 3>(3, 0) = 2.0 * (q.w() * Eigen::Matrix3d::Identity() - Skew(q.vec()));
  J.block<3, 1>(3, 3) = -2.0 * q.vec();
  return J;
}

// Scales rows [first, first + n) of a residual and its Jacobian to the square root of their Huber
// cost. d(g r) = (g I + 2 g' r r^T) dr with g = sqrt(HuberCost(s) / s).
template <int n, typename Residual, typename Jacobian>
void Robustify(double delta2, int first, Residual& r, Jacobian* J) {
  auto part = r.template segment<n>(first);
  const double s = part.squaredNorm();
  if (s <= delta2) return;
  const double cost = HuberCost(s, delta2);
  const double g = std::sqrt(cost / s);
  if (J != nullptr) {
    // dg/ds = (cost' s - cost) / (2 g s^2), cost' = sqrt(delta2 / s)
    const double dg = (std::sqrt(delta2 * s) - cost) / (2.0 * g * s * s);
    auto rows = J->template middleRows<n>(first);
    rows = (g * rows + 2.0 * dg * part * (part.transpose() * rows)).eval();
  }
  part *= g;
}

}  // namespace

PoseBlock ToBlock(const SE3& T) {
  const auto& q = T.rotation().coeffs();
  const auto& p = T.translation();
  return {q[0], q[1], q[2], q[3], p[0], p[1], p[2]};
}

SE3 FromBlock(const double* block) {
  return SE3(Eigen::Quaterniond(block[3], block[0], block[1], block[2]),
             Eigen::Vector3d(block[4], block[5], block[6]));
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseBlock out = ToBlock(FromBlock(x) * SE3::Exp(Eigen::Map<const Vector6d>(delta)));
  std::copy(out.begin(), out.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  const Eigen::Quaterniond q(x[3], x[0], x[1], x[2]);
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.bottomLeftCorner<3, 3>() = q.toRotationMatrix();
  J.block<3, 3>(0, 3) = 0.5 * (q.w() * Eigen::Matrix3d::Identity() + Skew(q.vec()));
  J.block<1, 3>(3, 3) = -0.5 * q.vec().transpose();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vector6d> out(y_minus_x);
  out = (FromBlock(x).inverse() * FromBlock(y)).Log();
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor67> J(jacobian);
  J = TangentOfBlock(Eigen::Quaterniond(x[3], x[0], x[1], x[2]));
  return true;
}

template <int kRows>
bool ReprojectionCost<kRows>::Evaluate(double const* const* parameters, double* residuals,
                                       double** jacobians) const {
  const double* x = parameters[0];
  const Eigen::Quaterniond q(x[3], x[0], x[1], x[2]);
  const Eigen::Matrix3d R_CW = q.toRotationMatrix().transpose();
  const Eigen::Vector3d p_C = R_CW * (Eigen::Map<const Eigen::Vector3d>(parameters[1]) -
                                      Eigen::Map<const Eigen::Vector3d>(x + 4));
  if (!(p_C.z() > kMinProjectionDepth)) return false;
  Eigen::Map<Eigen::Matrix<double, kRows, 1>> r(residuals);
  r = ReprojectionResidual(*camera_, observation_, p_C).template head<kRows>();
  Eigen::Matrix<double, kRows, 3> J;
  const bool derive = jacobians != nullptr;
  if (derive) J = ReprojectionJacobian(*camera_, observation_, p_C).template topRows<kRows>();
  Robustify<2>(kChi2Pixel, 0, r, derive ? &J : nullptr);
  if constexpr (kRows == 3) Robustify<1>(kChi2Depth, 2, r, derive ? &J : nullptr);
  if (!derive) return true;
  const Eigen::Matrix<double, kRows, 3> J_W = J * R_CW;
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, kRows, 3, Eigen::RowMajor>> out(jacobians[1]);
    out = J_W;
  }
  if (jacobians[0] != nullptr) {
    // p_C = Exp(-phi) (p_C - rho): columns -J for rho and J [p_C]x for phi, then to the block by
    // TangentOfBlock, of which only the two non-zero corners are multiplied.
    Eigen::Map<Eigen::Matrix<double, kRows, 7, Eigen::RowMajor>> out(jacobians[0]);
    const Eigen::Matrix<double, kRows, 3> J_phi = J * Skew(p_C);
    out.template leftCols<3>() = 2.0 * (q.w() * J_phi - J_phi * Skew(q.vec()));
    out.col(3) = -2.0 * (J_phi * q.vec());
    out.template rightCols<3>() = -J_W;
  }
  return true;
}

template class ReprojectionCost<2>;
template class ReprojectionCost<3>;

bool RelativePoseCost::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const SE3 T_WCa = FromBlock(parameters[0]);
  const SE3 T_WCb = FromBlock(parameters[1]);
  const SE3 T_ab = T_WCa.inverse() * T_WCb;
  const Vector6d error = (T_CbCa_ * T_ab).Log();
  Eigen::Map<Vector6d> r(residuals);
  r = sqrt_information_ * error;
  if (jacobians == nullptr) return true;
  const Matrix6d J_b = sqrt_information_ * RightJacobianInverseSE3(error);
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor67> out(jacobians[0]);
    out = -J_b * T_ab.inverse().Adjoint() * TangentOfBlock(T_WCa.rotation());
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowMajor67> out(jacobians[1]);
    out = J_b * TangentOfBlock(T_WCb.rotation());
  }
  return true;
}

// With T_WC Exp(d) the body moves by R_WC (rho + phi x p_CB).
bool HeightCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const SE3 T_WC = FromBlock(parameters[0]);
  residuals[0] = ((T_WC * p_CB_).z() - z_W_) / sigma_;
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  const Eigen::RowVector3d up_C = T_WC.rotation().toRotationMatrix().row(2) / sigma_;
  Eigen::Matrix<double, 1, 6> J;
  J << up_C, -up_C * Skew(p_CB_);
  Eigen::Map<Eigen::Matrix<double, 1, 7>> out(jacobians[0]);
  out = J * TangentOfBlock(T_WC.rotation());
  return true;
}

bool ScaledMotionCost::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const Vector6d shift = lever_ * Eigen::Map<const Eigen::Vector2d>(parameters[2]);
  const SE3 T_CaCb = T_CaCb_ * SE3::Exp(shift);
  double* of_poses[2] = {nullptr, nullptr};
  if (jacobians != nullptr) std::copy(jacobians, jacobians + 2, of_poses);
  RelativePoseCost(T_CaCb, sqrt_information_).Evaluate(parameters, residuals, of_poses);
  if (jacobians != nullptr && jacobians[2] != nullptr) {
    // T_CaCb moves on the right by J_right(shift) * lever * d, the error on the left by minus that;
    // J_left(e) = J_right(-e).
    const SE3 T_ab = FromBlock(parameters[0]).inverse() * FromBlock(parameters[1]);
    const Vector6d error = (T_CaCb.inverse() * T_ab).Log();
    Eigen::Map<Eigen::Matrix<double, 6, 2, Eigen::RowMajor>> J(jacobians[2]);
    J = -sqrt_information_ * RightJacobianInverseSE3(-error) * RightJacobianSE3(shift) * lever_;
  }
  return true;
}

bool ScalePrior::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  Eigen::Map<Eigen::Vector2d> r(residuals);
  r = inverse_sigma_ * Eigen::Map<const Eigen::Vector2d>(parameters[0]);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix2d> J(jacobians[0]);
    J = inverse_sigma_ * Eigen::Matrix2d::Identity();
  }
  return true;
}

}  // namespace gw::backend

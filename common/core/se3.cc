#include "common/core/se3.h"

#include <cmath>

namespace gw {
namespace {

// Below this angle the closed forms lose digits and Taylor series are exact to double precision.
constexpr double kSmallAngle = 1e-4;

constexpr double kUnitTolerance = 1.8e-15;  // of the squared norm; rounding leaves < 1e-15

// The left Jacobian's lower-left coupling block Q of SE(3) (Barfoot, State Estimation for Robotics,
// 2017, eq. 7.86), for the tangent order [translation; rotation].
Eigen::Matrix3d CouplingQ(const Eigen::Vector3d& rho, const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d P = Skew(rho);
  const Eigen::Matrix3d F = Skew(phi);
  double a;
  double b;
  double c;
  if (angle < 1e-2) {
    const double t2 = angle * angle;
    a = 1.0 / 6.0 - t2 / 120.0;
    b = 1.0 / 24.0 - t2 / 720.0;
    c = 1.0 / 120.0 - t2 / 2520.0;
  } else {
    const double t2 = angle * angle;
    const double t3 = t2 * angle;
    const double s = std::sin(angle);
    const double co = std::cos(angle);
    a = (angle - s) / t3;
    b = (t2 / 2.0 + co - 1.0) / (t2 * t2);
    c = (2.0 * angle - 3.0 * s + angle * co) / (2.0 * t3 * t2);
  }
  return 0.5 * P + a * (F * P + P * F + F * P * F) + b * (F * F * P + P * F * F - 3.0 * F * P * F) +
         c * (F * P * F * F + F * F * P * F);
}

Eigen::Matrix3d LeftJacobianSO3(const Eigen::Vector3d& a) {
  return RightJacobianSO3(-a);
}
Eigen::Matrix3d LeftJacobianInverseSO3(const Eigen::Vector3d& a) {
  return RightJacobianInverseSO3(-a);
}

}  // namespace

Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const double half = 0.5 * angle;
  const double k = angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  return Eigen::Quaterniond(std::cos(half), k * rotation_vector.x(), k * rotation_vector.y(),
                            k * rotation_vector.z());
}

Eigen::Vector3d LogSO3(const Eigen::Quaterniond& q) {
  const double w = q.w() < 0 ? -q.w() : q.w();
  const Eigen::Vector3d v = q.w() < 0 ? Eigen::Vector3d(-q.vec()) : Eigen::Vector3d(q.vec());
  const double n = v.norm();
  const double k =
      n < kSmallAngle ? 2.0 / w * (1.0 - n * n / (3.0 * w * w)) : 2.0 * std::atan2(n, w) / n;
  return k * v;
}

Eigen::Matrix3d RightJacobianSO3(const Eigen::Vector3d& a) {
  const double angle = a.norm();
  const Eigen::Matrix3d F = Skew(a);
  const double t2 = angle * angle;
  const double b = angle < kSmallAngle ? 0.5 - t2 / 24.0 : (1.0 - std::cos(angle)) / t2;
  const double c = angle < 1e-2 ? 1.0 / 6.0 - t2 / 120.0 : (angle - std::sin(angle)) / (t2 * angle);
  return Eigen::Matrix3d::Identity() - b * F + c * F * F;
}

Eigen::Matrix3d RightJacobianInverseSO3(const Eigen::Vector3d& a) {
  const double angle = a.norm();
  const Eigen::Matrix3d F = Skew(a);
  const double t2 = angle * angle;
  const double c = angle < 1e-2
                       ? 1.0 / 12.0 + t2 / 720.0
                       : 1.0 / t2 - (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
  return Eigen::Matrix3d::Identity() + 0.5 * F + c * F * F;
}

SE3::SE3(const Eigen::Quaterniond& q, const Eigen::Vector3d& p)
    : q_(std::abs(q.squaredNorm() - 1.0) < kUnitTolerance ? q : q.normalized()), p_(p) {}

SE3 SE3::inverse() const {
  const Eigen::Quaterniond qi = q_.conjugate();
  return SE3(qi, -(qi * p_));
}

SE3 SE3::operator*(const SE3& other) const {
  return SE3(q_ * other.q_, p_ + q_ * other.p_);
}

bool SE3::IsFinite() const {
  return q_.coeffs().allFinite() && p_.allFinite();
}

SE3 SE3::Exp(const Vector6d& tangent) {
  const Eigen::Vector3d phi = tangent.tail<3>();
  return SE3(ExpSO3(phi), LeftJacobianSO3(phi) * tangent.head<3>());
}

Vector6d SE3::Log() const {
  Vector6d out;
  const Eigen::Vector3d phi = LogSO3(q_);
  out.tail<3>() = phi;
  out.head<3>() = LeftJacobianInverseSO3(phi) * p_;
  return out;
}

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = q_.toRotationMatrix();
  m.topRightCorner<3, 1>() = p_;
  return m;
}

Matrix6d SE3::Adjoint() const {
  const Eigen::Matrix3d R = q_.toRotationMatrix();
  Matrix6d adj;
  adj << R, Skew(p_) * R, Eigen::Matrix3d::Zero(), R;
  return adj;
}

Matrix6d RightJacobianSE3(const Vector6d& a) {
  const Eigen::Vector3d rho = -a.head<3>();
  const Eigen::Vector3d phi = -a.tail<3>();
  const Eigen::Matrix3d J = LeftJacobianSO3(phi);
  Matrix6d out;
  out << J, CouplingQ(rho, phi), Eigen::Matrix3d::Zero(), J;
  return out;
}

Matrix6d RightJacobianInverseSE3(const Vector6d& a) {
  const Eigen::Vector3d rho = -a.head<3>();
  const Eigen::Vector3d phi = -a.tail<3>();
  const Eigen::Matrix3d Ji = LeftJacobianInverseSO3(phi);
  Matrix6d out;
  out << Ji, -Ji * CouplingQ(rho, phi) * Ji, Eigen::Matrix3d::Zero(), Ji;
  return out;
}

SE3 Interpolate(const SE3& T_a, const SE3& T_b, double fraction) {
  const Vector6d delta = (T_a.inverse() * T_b).Log();
  return T_a * SE3::Exp(fraction * delta);
}

}  // namespace gw

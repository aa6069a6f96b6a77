// Rigid motion in 3-D.
//
// T_AB maps coordinates of frame B into frame A: p_A = T_AB * p_B; inner letters cancel,
// T_AC = T_AB * T_BC. Tangent vectors are [translation; rotation] (m, rad), on the right:
// a perturbed pose is T * Exp(d). Covariances use the same order and side. The one convention
// of the project, pinned by se3_test.cc; frames are listed in docs/conventions.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gw {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The matrix of the cross product: Skew(a) * b = a x b.
Eigen::Matrix3d Skew(const Eigen::Vector3d& a);

// Rotation vector (axis * angle, rad) <-> unit quaternion. LogSO3 returns an angle in [0, pi].
Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d LogSO3(const Eigen::Quaterniond& q);

// Right Jacobian of SO(3): ExpSO3(a + d) ~ ExpSO3(a) * ExpSO3(RightJacobianSO3(a) * d), and its
// inverse.
Eigen::Matrix3d RightJacobianSO3(const Eigen::Vector3d& a);
Eigen::Matrix3d RightJacobianInverseSO3(const Eigen::Vector3d& a);

// Half a thousand sources read this header, and each instantiates what its inline functions need of
// Eigen, used or not: inline is only what the loops over points call.
class SE3 {
 public:
  SE3() : q_(1, 0, 0, 0), p_(0, 0, 0) {}
  // Normalises q, unless it already is unit but for rounding: normalising again would move last
  // bits, and a pose would not survive writing and reading. Precondition: q is finite and not zero.
  SE3(const Eigen::Quaterniond& q, const Eigen::Vector3d& p);

  static SE3 Exp(const Vector6d& tangent);
  Vector6d Log() const;

  const Eigen::Quaterniond& rotation() const { return q_; }
  const Eigen::Vector3d& translation() const { return p_; }
  Eigen::Matrix4d matrix() const;

  SE3 inverse() const;
  SE3 operator*(const SE3& other) const;
  // rotation() * v + translation() to the last bit: Eigen's product, written out.
  Eigen::Vector3d operator*(const Eigen::Vector3d& v) const {
    const double x = q_.x(), y = q_.y(), z = q_.z(), w = q_.w();
    const double ux = 2 * (y * v.z() - z * v.y());
    const double uy = 2 * (z * v.x() - x * v.z());
    const double uz = 2 * (x * v.y() - y * v.x());
    return {v.x() + w * ux + (y * uz - z * uy) + p_.x(),
            v.y() + w * uy + (z * ux - x * uz) + p_.y(),
            v.z() + w * uz + (x * uy - y * ux) + p_.z()};
  }

  // Ad(T): T * Exp(d) = Exp(Ad(T) * d) * T, order [translation; rotation].
  Matrix6d Adjoint() const;

  bool IsFinite() const;

 private:
  Eigen::Quaterniond q_;
  Eigen::Vector3d p_;
};

// Right Jacobian of SE(3): Exp(a + d) ~ Exp(a) * Exp(RightJacobianSE3(a) * d), and its inverse.
// The inverse is what the residual Log(inv(Z) * T) needs: d Log(E * Exp(d)) / dd = inverse at
// Log(E).
Matrix6d RightJacobianSE3(const Vector6d& a);
Matrix6d RightJacobianInverseSE3(const Vector6d& a);

// The geodesic between two poses: fraction 0 gives T_a, 1 gives T_b; outside [0, 1] extrapolates.
SE3 Interpolate(const SE3& T_a, const SE3& T_b, double fraction);

}  // namespace gw

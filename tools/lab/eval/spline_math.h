// The spline's equations over any scalar, so that Ceres can differentiate them. Inside of
// tools/lab/eval only.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace gw::eval::spline_math {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

// Below this squared angle (rad^2) the coefficients of Exp and Log are taken from their series:
// what is left out is below 1e-12 of them.
inline constexpr double kSmallAngle2 = 1e-4;

template <typename T>
struct Motion {
  Eigen::Quaternion<T> q;
  Vector3<T> p;

  Motion operator*(const Motion& other) const { return {q * other.q, p + q * other.p}; }
};

template <typename T>
Eigen::Quaternion<T> ExpRotation(const Vector3<T>& phi) {
  std::array<T, 4> wxyz;
  ceres::AngleAxisToQuaternion(phi.data(), wxyz.data());
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

template <typename T>
Vector3<T> LogRotation(const Eigen::Quaternion<T>& q) {
  const std::array<T, 4> wxyz = {q.w(), q.x(), q.y(), q.z()};
  Vector3<T> phi;
  ceres::QuaternionToAngleAxis(wxyz.data(), phi.data());
  return phi;
}

// Exp of the tangent [rho; phi].
template <typename T>
Motion<T> Exp(const Vector3<T>& rho, const Vector3<T>& phi) {
  using std::cos, std::sin, std::sqrt;
  const T a2 = phi.squaredNorm();
  T first, second;
  if (a2 < kSmallAngle2) {
    first = T(0.5) - a2 / 24.0 + a2 * a2 / 720.0;
    second = T(1.0 / 6.0) - a2 / 120.0 + a2 * a2 / 5040.0;
  } else {
    const T a = sqrt(a2);
    first = (1.0 - cos(a)) / a2;
    second = (a - sin(a)) / (a2 * a);
  }
  const Vector3<T> once = phi.cross(rho);
  return {ExpRotation(phi), rho + first * once + second * phi.cross(once)};
}

// Log of inv(A) B, as [rho; phi].
template <typename T>
void LogBetween(const Motion<T>& A, const Motion<T>& B, Vector3<T>* rho, Vector3<T>* phi) {
  using std::cos, std::sin, std::sqrt;
  const Eigen::Quaternion<T> inverse = A.q.conjugate();
  *phi = LogRotation<T>(inverse * B.q);
  const Vector3<T> p = inverse * (B.p - A.p);
  const T a2 = phi->squaredNorm();
  T factor;
  if (a2 < kSmallAngle2) {
    factor = T(1.0 / 12.0) + a2 / 720.0 + a2 * a2 / 30240.0;
  } else {
    const T a = sqrt(a2);
    factor = 1.0 / a2 - (1.0 + cos(a)) / (2.0 * a * sin(a));
  }
  const Vector3<T> once = phi->cross(p);
  *rho = p - 0.5 * once + factor * phi->cross(once);
}

// b1, b2, b3 of spline.h, and their derivatives by u.
inline std::array<double, 3> Basis(double u) {
  return {(5 + 3 * u - 3 * u * u + u * u * u) / 6, (1 + 3 * u + 3 * u * u - 2 * u * u * u) / 6,
          u * u * u / 6};
}
inline std::array<double, 3> BasisRate(double u) {
  return {(3 - 6 * u + 3 * u * u) / 6, (3 + 6 * u - 6 * u * u) / 6, u * u / 2};
}

template <typename T>
Motion<T> Pose(const std::array<Motion<T>, 4>& controls, double u) {
  const auto basis = Basis(u);
  Motion<T> out = controls[0];
  for (size_t j = 0; j < 3; ++j) {
    Vector3<T> rho, phi;
    LogBetween(controls[j], controls[j + 1], &rho, &phi);
    out = out * Exp<T>(basis[j] * rho, basis[j] * phi);
  }
  return out;
}

// Rate of rotation in the body frame (Sommer et al., "Efficient Derivative Computation for
// Cumulative B-Splines on Lie Groups", CVPR 2020, equation 30): the rotation of the spline on SE(3)
// is the spline of the rotations.
template <typename T>
Vector3<T> Rate(const std::array<Eigen::Quaternion<T>, 4>& controls, double u, double spacing_s) {
  const auto basis = Basis(u);
  const auto rate = BasisRate(u);
  Vector3<T> out = Vector3<T>::Zero();
  for (size_t j = 0; j < 3; ++j) {
    const Vector3<T> phi = LogRotation<T>(controls[j].conjugate() * controls[j + 1]);
    const Vector3<T> part = basis[j] * phi;
    out = ExpRotation<T>(part).conjugate() * out + (rate[j] / spacing_s) * phi;
  }
  return out;
}

}  // namespace gw::eval::spline_math

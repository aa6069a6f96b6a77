// The visual residual: where a landmark appears in a rectified stereo (or RGB-D) camera.
//
// Residual = (projected - observed) / sigma, rows u, v and, with depth, u_right = u - bf / z (px).
// Pixel (2 rows) and depth (1 row) are judged apart: they fail for different reasons, the one when
// the match is wrong, the other at depth edges and where images and depth were not taken at the
// same instant. One definition for tracking, triangulation and bundle adjustment.
#pragma once

#include <Eigen/Core>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "common/core/se3.h"
#include "common/vision/pyramid.h"

namespace gw {

// 95 % quantiles of chi-square with 1 and 2 degrees of freedom: the outlier gates, and squares of
// the Huber radii.
inline constexpr double kChi2Depth = 3.841;
inline constexpr double kChi2Pixel = 5.991;
inline constexpr double kMinProjectionDepth = 0.01;  // m; nearer points have no usable projection

// Where a landmark was seen in an image.
struct PixelObservation {
  double u = 0, v = 0;  // px
  double u_right = -1;  // px; only read when has_depth; may be negative at the image border
  bool has_depth = false;
  double inverse_sigma = 1;  // 1 / px
};
inline PixelObservation PixelOf(const Feature& f, const Pyramid& pyramid) {
  return {f.u, f.v, f.u_right, f.has_depth(), 1.0 / pyramid.Scale(f.level)};
}

// Whitened residual of a point in C; row 2 is zero without depth. Precondition: p_C.z() > 0.
inline Eigen::Vector3d ReprojectionResidual(const RectifiedCamera& camera,
                                            const PixelObservation& o, const Eigen::Vector3d& p_C) {
  const double iz = 1.0 / p_C.z();
  const double u = camera.fx * p_C.x() * iz + camera.cx;
  const double v = camera.fy * p_C.y() * iz + camera.cy;
  const double du_right = o.has_depth ? u - camera.bf() * iz - o.u_right : 0.0;
  return o.inverse_sigma * Eigen::Vector3d(u - o.u, v - o.v, du_right);
}

// d residual / d p_C.
inline Eigen::Matrix3d ReprojectionJacobian(const RectifiedCamera& camera,
                                            const PixelObservation& o, const Eigen::Vector3d& p_C) {
  const double iz = 1.0 / p_C.z();
  const double a = camera.fx * iz * o.inverse_sigma;
  const double b = camera.fy * iz * o.inverse_sigma;
  Eigen::Matrix3d J;
  J << a, 0, -a * p_C.x() * iz,  //
      0, b, -b * p_C.y() * iz,   //
      0, 0, 0;
  if (o.has_depth) {
    J(2, 0) = a;
    J(2, 2) = J(0, 2) + camera.bf() * iz * iz * o.inverse_sigma;
  }
  return J;
}

// d residual / d [rho; phi] of T_WC Exp([rho; phi]), from d residual / d p_C: d p_C = -rho + [p_C]x
// phi.
inline Eigen::Matrix<double, 3, 6> PoseJacobian(const Eigen::Matrix3d& J_point,
                                                const Eigen::Vector3d& p_C) {
  Eigen::Matrix<double, 3, 6> J;
  J << -J_point, J_point * Skew(p_C);
  return J;
}

// How well an observation fits.
struct ObservationFit {
  double chi2_pixel = 0;
  double chi2_depth = 0;                                      // 0 without depth
  bool pixel_ok() const { return chi2_pixel <= kChi2Pixel; }  // false for NaN
  bool depth_ok() const { return chi2_depth <= kChi2Depth; }
};
inline ObservationFit FitOf(const Eigen::Vector3d& residual) {
  return {residual.head<2>().squaredNorm(), residual[2] * residual[2]};
}
// Precondition: p_C.z() > 0.
inline ObservationFit FitOf(const RectifiedCamera& camera, const PixelObservation& o,
                            const Eigen::Vector3d& p_C) {
  return FitOf(ReprojectionResidual(camera, o, p_C));
}

}  // namespace gw

// The visual residual: where a landmark appears in a rectified stereo (or RGB-D) camera.
//
// Residual = (projected - measured) / sigma, rows u, v and, with depth, u_right = u - bf / z (px).
// Pixel (2 rows) and depth (1 row) are judged apart: they fail for different reasons, the one when
// the match is wrong, the other at depth edges and where images and depth were not taken at the
// same instant.
#pragma once

#include <Eigen/Core>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"

namespace gw::backend {

// 95 % quantiles of chi-square with 1 and 2 degrees of freedom: the outlier gates, and squares of
// the Huber radii.
inline constexpr double kChi2Depth = 3.841;
inline constexpr double kChi2Pixel = 5.991;
inline constexpr double kMinProjectionDepth = 0.01;  // m; nearer points have no usable projection

struct PixelMeasurement {
  double u = 0, v = 0;  // px
  double u_right = -1;  // px; only read when has_depth
  bool has_depth = false;
  double inverse_sigma = 1;  // 1 / px
};

// Whitened residual of a point in C; row 2 is zero without depth. Precondition: p_C.z() > 0.
inline Eigen::Vector3d ReprojectionResidual(const RectifiedCamera& camera,
                                            const PixelMeasurement& m, const Eigen::Vector3d& p_C) {
  const double iz = 1.0 / p_C.z();
  const double u = camera.fx * p_C.x() * iz + camera.cx;
  const double v = camera.fy * p_C.y() * iz + camera.cy;
  const double du_right = m.has_depth ? u - camera.bf() * iz - m.u_right : 0.0;
  return m.inverse_sigma * Eigen::Vector3d(u - m.u, v - m.v, du_right);
}

// d residual / d p_C.
inline Eigen::Matrix3d ReprojectionJacobian(const RectifiedCamera& camera,
                                            const PixelMeasurement& m, const Eigen::Vector3d& p_C) {
  const double iz = 1.0 / p_C.z();
  const double a = camera.fx * iz * m.inverse_sigma;
  const double b = camera.fy * iz * m.inverse_sigma;
  Eigen::Matrix3d J;
  J << a, 0, -a * p_C.x() * iz,  //
      0, b, -b * p_C.y() * iz,   //
      0, 0, 0;
  if (m.has_depth) {
    J(2, 0) = a;
    J(2, 2) = J(0, 2) + camera.bf() * iz * iz * m.inverse_sigma;
  }
  return J;
}

// How well a measurement fits.
struct SightingFit {
  double chi2_pixel = 0;
  double chi2_depth = 0;                                      // 0 without depth
  bool pixel_ok() const { return chi2_pixel <= kChi2Pixel; }  // false for NaN
  bool depth_ok() const { return chi2_depth <= kChi2Depth; }
};
// Precondition: p_C.z() > 0.
inline SightingFit FitOf(const RectifiedCamera& camera, const PixelMeasurement& m,
                         const Eigen::Vector3d& p_C) {
  const Eigen::Vector3d r = ReprojectionResidual(camera, m, p_C);
  return {r.head<2>().squaredNorm(), r[2] * r[2]};
}

}  // namespace gw::backend

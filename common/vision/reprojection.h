// The visual residual: where a landmark appears in a rectified stereo (or RGB-D) camera.
//
// Residual = (projected - observed) / sigma, rows u, v and, with depth, minus the disparity bf / z
// (px). Pixel (2 rows) and depth (1 row) are judged apart: they fail for different reasons, the one
// when the match is wrong, the other at depth edges and where images and depth were not taken at
// the same instant. The rows are independent: what places a feature beside its landmark moves both
// eyes alike. One definition for tracking, triangulation and bundle adjustment.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "common/core/chi_square.h"
#include "common/core/se3.h"
#include "common/vision/pyramid.h"

namespace gw {

// The outlier gates, and squares of the Huber radii.
inline constexpr double kChi2Depth = kChi2One95;
inline constexpr double kChi2Pixel = kChi2Two95;
inline constexpr double kMinProjectionDepth = 0.01;  // m; nearer points have no usable projection

// Where a landmark was seen in an image.
struct PixelObservation {
  double u = 0, v = 0;   // px
  double disparity = 0;  // px; only read when has_depth
  bool has_depth = false;
  double inverse_sigma = 1;            // 1 / px; of u and v
  double inverse_sigma_disparity = 1;  // 1 / px
};

// Share of the disparity by which the depth that is looked up for a feature is that of another
// point: a corner is not just where the depth pixels around it are. Robust residuals within 1 m are
// 0.5 to 0.6 % on a Kinect, an independent renderer and the simulator
// (docs/adr/0057-depth-as-the-sensor-gives-it.md).
inline constexpr double kDepthBeside = 0.005;

// Standard deviation (px) of the disparity of a feature: that of its pixel in a stereo pair, that
// of the sensor in a depth image. disparity > 0; 0 <= level < Pyramid::kMaxLevels.
inline double DisparitySigma(const RectifiedCamera& camera, const Pyramid& pyramid, int level,
                             double disparity) {
  if (!camera.has_depth_image()) return pyramid.Scale(level);
  return std::hypot(camera.disparity_sigma_px, kDepthBeside * disparity);
}

// Without depth.
inline PixelObservation PixelOf(const Feature& f, const Pyramid& pyramid) {
  return {.u = f.u, .v = f.v, .inverse_sigma = 1.0 / pyramid.Scale(f.level)};
}

// The observation of a landmark at the depth z (m). That depth decides whether its disparity
// counts, not the one that was measured: near the end of the range only those would count that
// came out too large.
inline PixelObservation ObservationOf(const Feature& f, const RectifiedCamera& camera,
                                      const Pyramid& pyramid, double z) {
  PixelObservation o = PixelOf(f, pyramid);
  if (!f.has_disparity() || z > camera.depth_max_m) return o;
  o.has_depth = true;
  o.disparity = static_cast<double>(f.u) - f.u_right;
  o.inverse_sigma_disparity = 1.0 / DisparitySigma(camera, pyramid, f.level, o.disparity);
  return o;
}

// Whitened residual of a point in C; row 2 is zero without depth. Precondition: p_C.z() > 0.
inline Eigen::Vector3d ReprojectionResidual(const RectifiedCamera& camera,
                                            const PixelObservation& o, const Eigen::Vector3d& p_C) {
  const double iz = 1.0 / p_C.z();
  const double u = camera.fx * p_C.x() * iz + camera.cx;
  const double v = camera.fy * p_C.y() * iz + camera.cy;
  const double nearer = o.has_depth ? o.disparity - camera.bf() * iz : 0.0;
  return {o.inverse_sigma * (u - o.u), o.inverse_sigma * (v - o.v),
          o.inverse_sigma_disparity * nearer};
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
  if (o.has_depth) J(2, 2) = camera.bf() * iz * iz * o.inverse_sigma_disparity;
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

// Smooths a noisy trajectory, such as the poses of a LiDAR at 10 Hz that serve as ground truth: the
// cumulative cubic B-spline on SE(3) (spline.h) that fits all samples best, robustly, optionally
// with the rates of a gyro; and says how well a sample is foretold by all others.
//
// Minimised (Ceres), over the control poses and the gyro's bias b:
//   sum_i  rho( |[(p(t_i) - p_i) / sigma_p ; Log(inv(R_i) R(t_i)) / sigma_r]|^2 )
//   + sum_k  rho( |w(t_k) - (w_k - b)|^2 / sigma_g^2 )
// rho: Cauchy's loss with the 99 % quantile of chi-square as its squared radius (16.81 for 6
// degrees of freedom, 11.34 for 3), so that a jump of a SLAM pulls little. The sigmas are measured
// from the samples: see MeasureNoise.
//
// How stiff the spline is, its knot spacing, is chosen by cross-validation: that with which a
// sample left out is foretold best. For each sample the residual of the fit without it follows from
// the fit with it, (I - H_ii)^-1 r_i with the leverage H_ii = J_i inv(sum J^T W J) J_i^T w_i (Cook
// and Weisberg, "Residuals and Influence in Regression", 1982, 2.2.7), at the weights of the
// solution.
#pragma once

#include <optional>

#include "tools/lab/eval/evaluate.h"
#include "tools/lab/eval/spline.h"

namespace gw::eval {

// Rate of rotation of the body, in the body frame.
struct BodyRate {
  Utime utime;
  Eigen::Vector3d w_B_rad_s;
};

struct SmoothOptions {
  std::optional<DurationUs> spacing;  // between knots; empty: by cross-validation
  std::vector<BodyRate> gyro;         // times strictly increase; empty: none
};

// Standard deviation per axis.
struct PoseNoise {
  double position_m = 0;
  double rotation_rad = 0;
};

// From third differences x_0 - 3 x_1 + 3 x_2 - x_3 of samples, in which a motion of constant
// acceleration cancels and white noise has 20 times its variance; their median, so that outliers do
// not count. Samples are taken as equally spaced; where motion changes within four of them the
// noise is overestimated. Precondition: at least 4 samples.
PoseNoise MeasureNoise(const Trajectory& samples);

struct SpacingFit {
  DurationUs spacing;
  double score = 0;  // mean robust cost of what is foretold; less is better
  Stats left_out_m;  // distances between samples and what the others say
  Stats left_out_deg;
  int64_t outliers = 0;  // samples beyond the radius of the loss
};

struct Smoothed {
  PoseSpline spline;
  PoseNoise noise;
  std::vector<SpacingFit> tried;  // by spacing
  size_t chosen = 0;              // of `tried`
  bool has_gyro = false;
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  // rad/s
};

// Error kBadData: fewer than 8 samples.
Result<Smoothed> Smooth(const Trajectory& samples, const SmoothOptions& options);

// The spline at a rate, from the first sample to the last, but not where samples are missing for
// longer than LongestPause(). Precondition: rate_hz > 0.
Trajectory Sample(const Smoothed& smoothed, const Trajectory& samples, double rate_hz);

}  // namespace gw::eval

// Is the published covariance of the pose honest?
//
// NEES (normalised estimation error squared, Bar-Shalom et al. 2001, 5.4) of the relative pose over
// a window from image a to image b: e^T inv(C) e with
//   e = Log( inv(inv(T_a) T_b of the truth) * inv(T_a) T_b of the estimate ),  6 degrees of
//   freedom
//   C = cov_motion of FRAME_POSE at b.
// An honest C puts 95 % of the windows inside the two-sided 95 % band of chi-square(6).
#pragma once

#include "tools/lab/eval/align.h"
#include "tools/lab/measure/slam_run.h"

namespace gw::measure {

inline constexpr double kNeesLow = 1.237;    // chi-square(6) at 2.5 %
inline constexpr double kNeesHigh = 14.449;  // and at 97.5 %

struct NeesCount {
  int64_t windows = 0;
  int64_t inside = 0;
  int64_t above = 0;      // too sure; the rest is too careful
  int64_t undefined = 0;  // C is not positive definite: counted in windows, not inside

  // Precondition: windows > 0.
  double share_inside() const { return static_cast<double>(inside) / static_cast<double>(windows); }
};

struct Consistency {
  NeesCount healthy;  // windows without a blind image
  NeesCount blind;    // the others
};

// One window per image that tells the covariance of its motion and has truth at both ends. Windows
// with an image that has no pose (initializing, lost) do not count.
Consistency MeasureConsistency(const SlamRun& run, const eval::Trajectory& truth);

}  // namespace gw::measure

// The numbers of a run with a fault.
#pragma once

#include <optional>

#include "tools/lab/eval/evaluate.h"
#include "tools/lab/measure/slam_run.h"

namespace gw::study {

// An error is beyond its covariance from so many sigmas on (Mahalanobis distance of the position).
inline constexpr double kTooSureSigmas = 5;

struct FaultNumbers {
  std::optional<double> ape_m;  // RMSE, live; empty: the alignment is not determined
  int64_t images = 0;
  int64_t without_pose = 0;  // lost, or initializing after the first pose
  int64_t blind = 0;         // dr_only
  // The longest span in which every image is tracking and its position, estimate and truth aligned
  // where the map begins, is off by more than kTooSureSigmas of the covariance it was published
  // with; s.
  double too_sure_s = 0;
  double too_sure_share = 0;  // of the images that are tracking
};

// T_BB: brings the poses of the run (T_WB T_BB) to the body of the truth; identity unless the
// extrinsics of the run were wrong.
FaultNumbers MeasureFault(const measure::SlamRun& run, const SE3& T_BB,
                          const eval::Trajectory& truth, eval::Alignment alignment);

// RMSE of the positions, m; empty: the alignment is not determined, or a pose is no number.
std::optional<double> Ape(const eval::Trajectory& truth, const eval::Trajectory& estimate,
                          eval::Alignment alignment);

// When the body has moved by 5 cm or 3 degrees: before, no sensor of motion can be found wrong.
Utime FirstMotion(const eval::Trajectory& truth);

}  // namespace gw::study

// The numbers of one run against the truth.
#pragma once

#include <optional>

#include "tools/lab/eval/evaluate.h"
#include "tools/lab/measure/consistency.h"
#include "tools/lab/measure/slam_run.h"

namespace gw::measure {

// How far the pose moves from one image to the next beyond what dead reckoning says it moved:
// |translation of inv(DR motion) * pose motion|. What a controller feels as a jump.
struct Jumps {
  double worst_m = 0;           // while the status says that nothing special happens
  double worst_recovery_m = 0;  // into an image that is recovering, or the first one that vision
                                // carries again after blind or lost ones: a published correction
};
Jumps MeasureJumps(const SlamRun& run);

struct Measures {
  int64_t images = 0;
  int64_t lost = 0;   // lost or initializing: the system does not claim to know the pose
  int64_t blind = 0;  // dr_only
  // Position error of all published poses, also of lost ones (a robot has to go on with them),
  // after alignment. Empty: nothing to compare, or the alignment is not determined.
  std::optional<double> ape_live_m, ape_final_m, ape_dr_m;
  std::optional<double> rpe_m, rpe_deg;  // RMSE over 1 s, live
  Jumps jumps;
  Consistency consistency;                  // over 1 s
  std::optional<double> ms_median, ms_p99;  // front-end time per image

  double tracked_share() const {
    return images == 0 ? 0 : static_cast<double>(images - lost) / static_cast<double>(images);
  }
};

Measures Measure(const SlamRun& run, const eval::Trajectory& truth, eval::Alignment alignment);

// Median of at least one value; between the middle two of an even count.
double Median(std::vector<double> values);
// The value that a share q of the values does not exceed (0 to 1; nearest rank from below).
// Precondition: at least one value.
double Quantile(std::vector<double> values, double q);

}  // namespace gw::measure

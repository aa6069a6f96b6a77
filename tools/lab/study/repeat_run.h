// Study "repeat-run" (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, table "Repeat-Run
// Evaluation"): the same log lap after lap without reset, the map kept. Are the poses published
// live in later laps as good as the map, and does what the run costs stop to grow?
#pragma once

#include <vector>

#include "tools/lab/eval/trajectory.h"
#include "tools/lab/slam/laps.h"
#include "tools/lab/study/growth.h"

namespace gw::study {

struct LapResult {
  double frame_rmse_m = 0;     // of the poses as published in this lap
  double keyframe_rmse_m = 0;  // of all keyframes of the run, as they are when the lap ends
  double known_share = 0;      // of the images, with a status other than lost and initializing
  GrowthSample cost;           // map when the lap ends, times over the lap

  // R(F/KF) of docs/glossary.md: 1 when live poses are as good as the map.
  double ratio() const { return frame_rmse_m / keyframe_rmse_m; }
};

// One per lap; each trajectory is aligned to the truth on its own (SE(3), as in the table named
// above). Error: kBadData when there is nothing to compare.
Result<std::vector<LapResult>> MeasureLaps(const eval::Trajectory& truth,
                                           const tools::SlamSession& session,
                                           const std::vector<tools::Lap>& laps,
                                           const std::vector<GrowthSample>& samples);

}  // namespace gw::study

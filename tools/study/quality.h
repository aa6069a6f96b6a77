// Study "quality" (paper fig. "tracking_quality"): does the pose error of the vision-only system
// depend on how many features an image has and how many of them are tracked?
#pragma once

#include <string>
#include <vector>

#include "tools/eval/trajectory.h"
#include "tools/measure/slam_run.h"

namespace gw::study {

// One image: its counts and its error.
struct QualitySample {
  int num_detected = 0;
  int num_tracked = 0;
  double ape_m = 0;     // after SE(3) alignment of the whole run, as in the paper
  double motion_m = 0;  // of the motion over the second before: does not remember older errors
};

// Images with truth now and a second ago. Error: as of eval::Evaluate.
Result<std::vector<QualitySample>> QualitySamples(const measure::SlamRun& run,
                                                  const eval::Trajectory& truth);

struct QualityBin {
  int low = 0, high = 0;  // counts in [low, high)
  int64_t images = 0;
  double ape_rmse_m = 0, motion_rmse_m = 0;
};

// Bins of equal width from 0 on, the last one open above; without those that hold no image.
std::vector<QualityBin> BinBy(const std::vector<QualitySample>& samples, int QualitySample::*count,
                              int width, int num_bins);

}  // namespace gw::study

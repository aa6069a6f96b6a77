// Study "quality" (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, figure "tracking_quality"):
// does the pose error of vision depend on how many features an image has and how many of them are
// tracked?
//
// Run with variant da: poses come from vision alone, dead reckoning only helps to find matches and
// bridges what vision loses, so that weak images are seen more than once. With `none` the first
// loss would end the run, and errors after it say nothing of the counts.
#pragma once

#include <string>
#include <vector>

#include "tools/lab/eval/trajectory.h"
#include "tools/lab/measure/slam_run.h"

namespace gw::study {

// One second of the run, by the image that ends it. An error of the motion comes from the weakest
// image in it, so that counts are the lowest of that second.
struct QualitySample {
  int num_detected = 0;
  int num_tracked = 0;
  bool seen = true;     // vision gave a pose for each of its images, none of them a correction
  double motion_m = 0;  // error of the motion
};

// Images with truth now and a second ago. Error: as of eval::Evaluate.
Result<std::vector<QualitySample>> QualitySamples(const measure::SlamRun& run,
                                                  const eval::Trajectory& truth);

struct QualityBin {
  int low = 0, high = 0;     // counts in [low, high)
  int64_t seconds = 0;       // samples
  int64_t seen = 0;          // of them with vision in each image
  double motion_rmse_m = 0;  // of those; 0 when there are none
};

// Bins of equal width from 0 on, the last one open above; without those that hold no sample.
std::vector<QualityBin> BinBy(const std::vector<QualitySample>& samples, int QualitySample::*count,
                              int width, int num_bins);

}  // namespace gw::study

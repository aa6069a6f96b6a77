// What a laser scanner's SLAM would have said in place of the simulator's truth.
#pragma once

#include "tools/lab/bench_suite/suite.h"
#include "tools/lab/eval/trajectory.h"

namespace gw::bench {

// Samples of the truth at the rate, with white noise that depends on `seed` and the sample's number
// alone, smoothed and sampled at 100 Hz. Error: too few samples.
Result<eval::Trajectory> AsOfLidar(const eval::Trajectory& truth, const LidarTruth& lidar,
                                   uint64_t seed);

}  // namespace gw::bench

// Scores trajectories of other systems by the protocol of this one.
#pragma once

#include <string>
#include <vector>

#include "tools/lab/bench_suite/cells.h"

namespace gw::bench {

// What the log of an input says that a trajectory is compared with.
struct InputTruth {
  eval::Trajectory T_GB;
  int64_t images = 0;  // of the camera
};
// Error: a log that cannot be read, or without ground truth.
Result<InputTruth> ReadInputTruth(const std::string& log);

// One result per run of the method on this input. A trajectory that is not there, or cannot be
// read, is a run that failed. Images: those of the log; lost: the share of the truth's time in
// which the trajectory is silent (eval::Completeness). Error: the robot configuration cannot be
// read.
Result<std::vector<CellResult>> ScoreOther(const OtherMethod& method, int runs,
                                           const PreparedInput& input, const InputTruth& truth,
                                           eval::Alignment alignment);

}  // namespace gw::bench

// Study "alpha-sweep" (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, figure "dr_weight"): the
// pose error over a span of a log with a fixed scale of the DR information, against that scale,
// with pure dead reckoning and the adaptive scale for comparison.
#pragma once

#include <vector>

#include "tools/lab/eval/trajectory.h"

namespace gw::study {

// RMSE of the positions when the first poses coincide: the drift over the span, which needs no
// alignment and so works on straight ways too. Error: kBadData without a pose that has truth.
Result<double> DriftRmse(const eval::Trajectory& truth, const eval::Trajectory& est);

struct AlphaResult {
  int log10_alpha = 0;
  std::vector<double> rmse_m;  // per run
};

// The results' best median. Precondition: not empty, each with a run.
const AlphaResult& BestOf(const std::vector<AlphaResult>& results);

}  // namespace gw::study

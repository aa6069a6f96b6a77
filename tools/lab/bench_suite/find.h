// Finds the sequences of the CID-SIMS data set (Zhang et al., "CID-SIMS: Complex indoor dataset
// with semantic information and multi-sensor data from a ground wheeled robot viewpoint", IJRR
// 2023) in a folder, as they were unpacked.
#pragma once

#include <string>

#include "tools/lab/bench_suite/suite.h"

namespace gw::bench {

// A sequence is a folder that holds associations.txt; its name is the folder's. Adds each to
// `inputs` with its mounting and the calibration file, which is looked for beside the sequence and
// in the folders above it, up to `data`. One without wheels (no odom.txt, or no line in it) is left
// out and named in `left_out`: two of the data set have none. Error: kNotFound, when there is no
// sequence, or no calibration.
Result<Done> FindCidSims(const CidSimsSearch& search, const std::string& data,
                         std::vector<SuiteInput>* inputs, std::vector<std::string>* left_out);

}  // namespace gw::bench

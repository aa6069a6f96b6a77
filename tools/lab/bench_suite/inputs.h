// Makes the logs that a suite names. What is rendered, imported or edited is kept in a cache folder
// under a name that holds the hash of its recipe (scenario and map, options, faults), so that it is
// made once. A new version of gw-sim, gw-import or gw-fault does not make it again: delete the
// file.
#pragma once

#include <string>

#include "tools/lab/bench_suite/suite.h"
#include "tools/lab/eval/trajectory.h"

namespace gw::bench {

struct PreparedInput {
  std::string name;
  std::string log, config;  // paths
  std::string log_hash;     // of the log's bytes
  std::string config_hash;  // of the robot YAML's bytes
  eval::Trajectory truth;
};

// Error: what the programs say, or a log without ground truth.
Result<PreparedInput> PrepareInput(const SuiteInput& input, const std::string& cache);

}  // namespace gw::bench

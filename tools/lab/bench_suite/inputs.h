// Makes the logs that a suite names. What is rendered, imported or edited is kept in a cache folder
// under a name that holds the hash of its recipe (scenario and map, options, faults), so that it is
// made once. A new version of gw-sim, gw-import or gw-fault does not make it again: delete the
// file. What was made for an input is noted in OUT/inputs/NAME.yaml, which is what runs and tables
// read: they need no suite.
#pragma once

#include <string>

#include "tools/lab/bench_suite/suite.h"

namespace gw::bench {

struct PreparedInput {
  std::string name;
  std::string log, config;  // paths
  std::string log_hash;     // of the log's bytes
  std::string config_hash;  // of the robot YAML's bytes
};

// Makes the log unless it is there, and writes the note; a note that says the same already stays
// untouched, so that its time tells when the input changed. Error: what the programs say.
Result<PreparedInput> PrepareInput(const SuiteInput& input, const std::string& cache,
                                   const std::string& out);

// The note of an input. Error: kNotFound, when it was not prepared; kBadData.
Result<PreparedInput> ReadPreparedInput(const std::string& name, const std::string& out);

// Everything on disk that the input's log is made of, for programs that look at file times: the
// scenario and the files beside its map, the log and its configuration, the recording's folder.
std::vector<std::string> SourcesOf(const SuiteInput& input);

}  // namespace gw::bench

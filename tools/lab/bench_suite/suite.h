// A suite: which inputs gw-bench runs, with which variants, how often.
#pragma once

#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/lab/eval/align.h"

namespace gw::bench {

enum class Source {
  kLog,       // a log and its robot configuration, as they are
  kScenario,  // rendered by gw-sim
  kImport,    // a recording, imported by gw-import
};

struct SuiteInput {
  std::string name;  // letters, digits, _ . -
  Source source = Source::kLog;
  std::string path;                  // of the log, the scenario or the recording
  std::string config;                // kLog: robot YAML
  std::string format;                // kImport: tum, euroc, ...
  std::vector<std::string> options;  // further arguments of gw-sim or gw-import
  std::vector<std::string> fault;    // arguments of gw-fault; empty: the log stays as it is
  // Keys of the robot YAML ("frontend.matching") and what they are set to; others stay.
  std::vector<std::pair<std::string, std::string>> set;
  eval::Alignment alignment = eval::Alignment::kSe3;  // the suite's, unless the input has its own
};

struct Suite {
  std::string name;
  int runs = 5;  // with seeds 0, 1, ... (see tools/lab/slam/run_log.h)
  eval::Alignment alignment = eval::Alignment::kSe3;
  std::vector<std::string> variants;
  std::vector<SuiteInput> inputs;
};

// Paths of logs and scenarios are relative to the suite file, recordings to `data`; all are
// absolute afterwards. Error: kNotFound; kBadConfig with a line for each mistake.
Result<Suite> LoadSuite(const std::string& path, const std::string& data);

}  // namespace gw::bench

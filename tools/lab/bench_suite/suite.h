// A suite: which inputs gw-bench runs, with which variants, how often.
#pragma once

#include <optional>
#include <string>
#include <utility>
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
  std::string path;    // of the log, the scenario or the recording
  std::string config;  // kLog: robot YAML
  std::string format;  // kImport: tum, euroc, ...
  // Further arguments of gw-sim or gw-import. What begins with {data} or {suite} is in the folder
  // of the recordings, or of the suite file.
  std::vector<std::string> options;
  std::vector<std::string> fault;  // arguments of gw-fault; empty: the log stays as it is
  // Keys of the robot YAML ("frontend.matching") and what they are set to; others stay.
  std::vector<std::pair<std::string, std::string>> set;
  eval::Alignment alignment = eval::Alignment::kSe3;  // the suite's, unless the input has its own
};

// Sequences of CID-SIMS that are looked for in the folder of recordings (find.h).
struct CidSimsSearch {
  bool wanted = false;
  std::vector<std::string> low;  // sequences with the low mounting of the camera; others: high
};

// Ground truth as a robot with a laser scanner has it, in place of the simulator's: at a low rate,
// with white noise, smoothed (tools/lab/eval/smooth.h).
struct LidarTruth {
  double rate_hz = 0;  // 0: the truth as the log has it
  double metres = 0;   // sigma per axis
  double degrees = 0;
};

// Another system, which comes with its trajectories.
struct OtherMethod {
  std::string name;
  std::string pattern;   // path of a TUM file, with {sequence}, and {run} where there are several
  bool of_body = false;  // poses of the body; otherwise of the camera's optical frame
};

// A row of the literature: what somebody measured on the real data.
struct PublishedRow {
  std::string name;
  std::optional<double> completeness;  // 0 to 1
  std::optional<double> ape_m;
  std::string source;  // where it stands, with its date
};

struct Suite {
  std::string name;
  int runs = 5;  // with seeds 0, 1, ... (see tools/lab/slam/run_log.h)
  eval::Alignment alignment = eval::Alignment::kSe3;
  std::vector<std::string> variants;
  std::vector<SuiteInput> inputs;
  CidSimsSearch cid_sims;
  LidarTruth lidar_truth;
  std::vector<OtherMethod> methods;
  std::vector<PublishedRow> published;
};

// Paths of logs, scenarios, other systems' trajectories and published rows are relative to the
// suite file, recordings to `data`; all are absolute afterwards. Error: kNotFound; kBadConfig with
// a line for each mistake.
Result<Suite> LoadSuite(const std::string& path, const std::string& data);

}  // namespace gw::bench

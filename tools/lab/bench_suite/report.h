// What gw-bench leaves behind: tables for people and for scripts, and plots.
#pragma once

#include <string>
#include <vector>

#include "tools/lab/bench_suite/protocol.h"
#include "tools/lab/bench_suite/suite.h"

namespace gw::bench {

struct BenchReport {
  Suite suite;  // as it was run
  int jobs = 1;
  std::vector<CellResult> results;
};

std::string RenderMarkdown(const BenchReport& report);
std::string RenderCsv(const BenchReport& report);  // one line per run
// Like figure "cid_bench" of Du, Peng, Vela, "Good Weights", arXiv 2509.22910.
std::string RenderRankingPlot(const BenchReport& report);
std::string RenderInputsPlot(const BenchReport& report);  // a panel per input

}  // namespace gw::bench

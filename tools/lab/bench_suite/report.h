// What gw-bench leaves behind: tables for people and for scripts, and plots.
#pragma once

#include <string>
#include <vector>

#include "tools/lab/bench_suite/protocol.h"
#include "tools/lab/bench_suite/suite.h"
#include "tools/lab/plot/drawing.h"

namespace gw::bench {

struct BenchReport {
  Suite suite;  // as it was run
  std::vector<CellResult> results;
};

// The same bytes wherever and in whatever order the cells were run: nothing in it is a time that
// was measured.
std::string RenderMarkdown(const BenchReport& report);
std::string RenderCsv(const BenchReport& report);  // one line per run
// Front-end time per image, a line per run. Runs on the same machine at the same time disturb it.
std::string RenderTimingCsv(const BenchReport& report);
// Like figure "cid_bench" of Du, Peng, Vela, "Good Weights", arXiv 2509.22910.
plot::Drawing DrawRanking(const BenchReport& report);
plot::Drawing DrawInputs(const BenchReport& report);  // a panel per input

}  // namespace gw::bench

// One cell of the benchmark: an input, a variant, a seed. Runs gw-slam as a child process.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/lab/bench_suite/inputs.h"
#include "tools/lab/measure/measures.h"

namespace gw::bench {

struct Cell {
  const PreparedInput* input = nullptr;
  std::string variant;
  int seed = 0;
};

struct CellResult {
  std::string input;
  std::string variant;
  int seed = 0;
  std::string log;  // its file name
  std::string log_hash;
  std::string slam_hash;  // of the bytes of gw-slam
  measure::RunOrigin origin;
  std::optional<measure::Measures> measures;  // empty: gw-slam failed
  std::string failure;                        // ... and said this
};

struct CellOptions {
  std::string out;  // the cell's files go to OUT/cells/INPUT/VARIANT/seed-N
  int jobs = 1;     // cells at the same time
  eval::Alignment alignment = eval::Alignment::kSe3;
};

// Results in the order of the cells. A cell that is finished is not run again, as long as gw-slam,
// log, robot YAML, variant and seed are the same; its numbers are taken from its files anew.
// finished: called after each, one at a time. Error: gw-slam is not there, the folder cannot be
// made.
Result<std::vector<CellResult>> RunCells(
    const std::vector<Cell>& cells, const CellOptions& options,
    const std::function<void(const CellResult& result, bool was_there)>& finished);

}  // namespace gw::bench

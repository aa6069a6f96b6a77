// One cell of the benchmark: an input, a variant, a seed. A cell is a job of its own: it reads the
// note of its input and the copy of gw-slam in OUT, and leaves its files in a folder of its own, so
// that cells may run in any order, at the same time and on other machines that share OUT.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/lab/bench_suite/inputs.h"
#include "tools/lab/measure/measures.h"

namespace gw::bench {

struct Cell {
  std::string input;
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
  std::optional<measure::Measures> measures;  // empty: the cell is not finished
  std::string failure;                        // ... because of this
  bool external = false;                      // of another system
};

// All cells of the suite whose "INPUT VARIANT" the regular expression matches: by input, then
// variant, then seed. Error kInvalidArgument: no expression, or none matches.
Result<std::vector<Cell>> SelectCells(const Suite& suite, const std::string& filter);

// Copies gw-slam into OUT, so that a build meanwhile does not mix two versions in one table. A copy
// that is the same stays untouched. Error: gw-slam is not there, OUT cannot be written.
Result<Done> KeepSlam(const std::string& out);

// Of a variant, as it stands in the name of a folder.
std::string VariantFolder(const std::string& variant);
// Relative to OUT. Its file "key" says what the result depends on; it is written last.
std::string CellFolder(const Cell& cell);

// The copy of gw-slam in OUT, named by its bytes.
struct KeptSlam {
  std::string path;
  std::string hash;
};
Result<KeptSlam> FindSlam(const std::string& out);

// Runs the cell, unless it is finished with the same gw-slam, log, robot YAML, variant and seed.
// Returns whether it was there. Error: what gw-slam says; then, and when this process is killed,
// the cell is not finished.
Result<bool> RunCell(const Cell& cell, const PreparedInput& input, const KeptSlam& slam,
                     const std::string& out);

// The numbers of a finished cell, from its files.
CellResult ReadCell(const Cell& cell, const PreparedInput& input, const eval::Trajectory& truth,
                    eval::Alignment alignment, const KeptSlam& slam, const std::string& out);

}  // namespace gw::bench

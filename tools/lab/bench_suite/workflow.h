// A suite as a set of independent jobs for other people's schedulers: a Snakemake workflow (Moelder
// et al., "Sustainable data analysis with Snakemake", 2021), which runs on one machine or through a
// cluster's queue, and plain lists of commands, for GNU parallel or whatever takes one command a
// line (docs/adr/0050-a-suite-is-a-set-of-jobs.md).
#pragma once

#include <string>
#include <vector>

#include "tools/lab/bench_suite/cells.h"

namespace gw::bench {

struct Workflow {
  std::string program;                 // this one; absolute
  std::string suite_file;              // absolute
  std::string out;                     // absolute
  std::vector<std::string> arguments;  // that every job needs beside suite and OUT
  std::vector<SuiteInput> inputs;      // of the suite
  std::vector<Cell> cells;
};

// File names, relative to OUT, and their texts: Snakefile, slurm/config.yaml (a profile of
// Snakemake), inputs.jobs, cells.jobs and table.jobs (one command a line, to be run in this order).
std::vector<std::pair<std::string, std::string>> RenderWorkflow(const Workflow& workflow);

}  // namespace gw::bench

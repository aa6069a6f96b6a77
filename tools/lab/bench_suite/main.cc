// gw-bench: every input x every variant x every run of a suite, and the tables that come of it.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "common/core/hash.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/find.h"
#include "tools/lab/bench_suite/lidar_truth.h"
#include "tools/lab/bench_suite/other_methods.h"
#include "tools/lab/bench_suite/programs.h"
#include "tools/lab/bench_suite/report.h"
#include "tools/lab/bench_suite/workflow.h"
#include "tools/lab/plot/html_report.h"

namespace gw::bench {
namespace {

struct Arguments {
  std::string suite;
  std::string out;
  std::string workflow;
  std::string cache;
  std::string data;
  std::string filter;
  int runs = 0;  // 0: as the suite says
  Cell cell;     // of prepare (its input) and run-job
};

Result<Done> MakeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  return Done{};
}

Result<Suite> LoadSuiteAsAsked(const Arguments& args) {
  auto suite = LoadSuite(args.suite, args.data);
  if (!suite) return suite;
  if (args.runs > 0) suite->runs = args.runs;
  if (!suite->cid_sims.wanted) return suite;
  std::vector<std::string> left_out;
  const auto found = FindCidSims(suite->cid_sims, args.data, &suite->inputs, &left_out);
  if (!found) return found.error();
  for (const std::string& name : left_out) {
    std::fprintf(stderr, "gw-bench: %s: has no wheels, left out\n", name.c_str());
  }
  return suite;
}

const SuiteInput* FindInput(const Suite& suite, const std::string& name) {
  for (const SuiteInput& input : suite.inputs) {
    if (input.name == name) return &input;
  }
  return nullptr;
}

Result<PreparedInput> Prepare(const Arguments& args, const SuiteInput& input) {
  if (input.source == Source::kImport && !std::filesystem::is_directory(input.path)) {
    return Error{ErrorCode::kNotFound, input.name + ": no recording " + input.path +
                                           "; --data names the folder that holds it"};
  }
  auto prepared = PrepareInput(input, args.cache, args.out);
  if (!prepared) return Error{prepared.error().code, input.name + ": " + prepared.error().message};
  return prepared;
}

Result<Done> PrepareOne(const Arguments& args) {
  const auto suite = LoadSuiteAsAsked(args);
  if (!suite) return suite.error();
  const SuiteInput* const input = FindInput(*suite, args.cell.input);
  if (input == nullptr) {
    return Error{ErrorCode::kInvalidArgument, "--input " + args.cell.input + ": not in the suite"};
  }
  const auto prepared = Prepare(args, *input);
  return prepared ? Result<Done>(Done{}) : Result<Done>(prepared.error());
}

Result<Done> RunJob(const Arguments& args) {
  const auto suite = LoadSuiteAsAsked(args);
  if (!suite) return suite.error();
  const auto& variants = suite->variants;
  if (FindInput(*suite, args.cell.input) == nullptr ||
      std::find(variants.begin(), variants.end(), args.cell.variant) == variants.end()) {
    return Error{ErrorCode::kInvalidArgument,
                 args.cell.input + " " + args.cell.variant + ": not in the suite"};
  }
  const auto input = ReadPreparedInput(args.cell.input, args.out);
  if (!input) return input.error();
  const auto slam = FindSlam(args.out);
  if (!slam) return slam.error();
  const auto was_there = RunCell(args.cell, *input, *slam, args.out);
  return was_there ? Result<Done>(Done{}) : Result<Done>(was_there.error());
}

Result<std::vector<CellResult>> ReadAll(const Arguments& args, const Suite& suite,
                                        const std::vector<Cell>& cells) {
  const auto slam = FindSlam(args.out);
  if (!slam) return slam.error();
  std::vector<CellResult> results;
  std::string of;  // the input that these two are of
  PreparedInput prepared;
  InputTruth truth;
  for (const Cell& cell : cells) {
    const eval::Alignment alignment = FindInput(suite, cell.input)->alignment;
    if (of != cell.input) {
      auto input = ReadPreparedInput(cell.input, args.out);
      if (!input) return input.error();
      auto read = ReadInputTruth(input->log);
      if (!read) return read.error();
      prepared = *std::move(input);
      truth = *std::move(read);
      if (suite.lidar_truth.rate_hz > 0) {
        auto lidar = AsOfLidar(truth.T_GB, suite.lidar_truth, Fnv1a(cell.input));
        if (!lidar) return lidar.error();
        truth.T_GB = *std::move(lidar);
      }
      of = cell.input;
      for (const OtherMethod& method : suite.methods) {
        auto others = ScoreOther(method, suite.runs, prepared, truth, alignment);
        if (!others) return others.error();
        results.insert(results.end(), others->begin(), others->end());
      }
    }
    results.push_back(ReadCell(cell, prepared, truth.T_GB, alignment, *slam, args.out));
  }
  return results;
}

Result<Done> Collect(const Arguments& args) {
  auto suite = LoadSuiteAsAsked(args);
  if (!suite) return suite.error();
  const auto cells = SelectCells(*suite, args.filter);
  if (!cells) return cells.error();
  auto results = ReadAll(args, *suite, *cells);
  if (!results) return results.error();
  const BenchReport report{*std::move(suite), *std::move(results)};
  const std::string table = RenderMarkdown(report);
  const plot::Drawing ranking = DrawRanking(report), inputs = DrawInputs(report);
  const auto page = plot::RenderHtml("gw-bench " + report.suite.name, {ranking, inputs}, table);
  if (!page) return page.error();
  const std::pair<const char*, std::string> files[] = {{"table.md", table},
                                                       {"table.csv", RenderCsv(report)},
                                                       {"timing.csv", RenderTimingCsv(report)},
                                                       {"ranking.svg", ranking.svg},
                                                       {"inputs.svg", inputs.svg},
                                                       {"report.html", *page}};
  for (const auto& [name, text] : files) {
    const auto written = tools::WriteTextFile(args.out + "/" + name, text);
    if (!written) return written.error();
  }
  std::fputs(table.c_str(), stdout);
  for (const CellResult& r : report.results) {
    if (!r.measures && !r.external) {
      return Error{ErrorCode::kBadData, "some runs have no result, see the end of the table"};
    }
  }
  return Done{};
}

// All inputs and cells, one after the other: for machines without Snakemake and for short suites.
Result<Done> RunAll(const Arguments& args) {
  const auto suite = LoadSuiteAsAsked(args);
  if (!suite) return suite.error();
  const auto cells = SelectCells(*suite, args.filter);
  if (!cells) return cells.error();
  const auto kept = KeepSlam(args.out);
  if (!kept) return kept.error();
  const auto slam = FindSlam(args.out);
  if (!slam) return slam.error();
  std::optional<PreparedInput> input;
  size_t done = 0;
  for (const Cell& cell : *cells) {
    if (!input || input->name != cell.input) {
      auto prepared = Prepare(args, *FindInput(*suite, cell.input));
      if (!prepared) return prepared.error();
      input = *std::move(prepared);
    }
    const auto was_there = RunCell(cell, *input, *slam, args.out);
    std::fprintf(stderr, "gw-bench: %zu/%zu %s %s seed %d%s\n", ++done, cells->size(),
                 cell.input.c_str(), cell.variant.c_str(), cell.seed,
                 !was_there   ? (": " + was_there.error().message).c_str()
                 : *was_there ? " (was there)"
                              : "");
  }
  return Collect(args);
}

Result<Done> WriteWorkflow(const Arguments& args) {
  const auto suite = LoadSuiteAsAsked(args);
  if (!suite) return suite.error();
  auto cells = SelectCells(*suite, args.filter);
  if (!cells) return cells.error();
  const auto kept = KeepSlam(args.out);
  if (!kept) return kept.error();
  const auto program = SiblingProgram("gw-bench");
  if (!program) return program.error();
  const auto absolute = [](const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal().string();
  };
  Workflow workflow{*program, absolute(args.suite), absolute(args.out),
                    {},       suite->inputs,        *std::move(cells)};
  workflow.arguments = {"--cache", absolute(args.cache)};
  if (!args.data.empty()) {
    workflow.arguments.insert(workflow.arguments.end(), {"--data", absolute(args.data)});
  }
  if (args.runs > 0) {
    workflow.arguments.insert(workflow.arguments.end(), {"--runs", std::to_string(args.runs)});
  }
  if (!args.filter.empty()) {
    workflow.arguments.insert(workflow.arguments.end(), {"--filter", args.filter});
  }
  const auto slurm = MakeFolder(args.out + "/slurm");
  if (!slurm) return slurm.error();
  for (const auto& [name, text] : RenderWorkflow(workflow)) {
    const auto written = tools::WriteTextFile(args.out + "/" + name, text);
    if (!written) return written.error();
  }
  std::printf("%s/Snakefile: %zu runs; its head says how to start it\n", workflow.out.c_str(),
              workflow.cells.size());
  return Done{};
}

using Command = Result<Done> (*)(const Arguments&);

Result<Done> RunCommand(Arguments args, Command command) {
  if (!args.workflow.empty()) args.out = args.workflow;
  if (args.cache.empty()) args.cache = args.out + "/cache";
  for (const std::string& folder : {args.out, args.cache}) {
    const auto made = MakeFolder(folder);
    if (!made) return made.error();
  }
  return command(args);
}

// What the program and each of its jobs take. The option --out.
gw::cli::Option* AddOptions(gw::cli::Command* app, Arguments* args) {
  app->AddOption("suite", args->suite, "suite file (YAML, config/suites)");
  app->AddOption("--runs", args->runs, "runs per input and variant, in place of the suite's")
      ->InRange(1, 100);
  app->AddOption("--filter", args->filter,
                 "regular expression: only where it matches \"INPUT VARIANT\"");
  app->AddOption("--cache", args->cache, "folder for rendered and imported logs (OUT/cache)");
  app->AddOption("--data", args->data, "folder that holds the suite's recordings");
  return app->AddOption("--out", args->out, "folder for tables, plots and runs");
}

}  // namespace
}  // namespace gw::bench

int main(int argc, char** argv) {
  using gw::bench::Arguments;
  Arguments args;
  gw::cli::Command app(
      "Runs gw-slam on every input of a suite with every variant, several times with perturbed "
      "starts,\nand writes table.md, table.csv, timing.csv, ranking.svg, inputs.svg and "
      "report.html. Runs that "
      "are\nfinished are not repeated while gw-slam, log and configuration stay the same. With "
      "--workflow a suite becomes jobs\nfor Snakemake (this machine, Slurm) and GNU parallel.\n"
      "Exit: 0 ok, 1 failed, 2 usage, 78 bad suite or scenario.");
  app.RequireCommands(0, 1);
  gw::cli::Option* const out = gw::bench::AddOptions(&app, &args);
  app.AddOption("--workflow", args.workflow,
                "folder for all that, and for the workflow, which is written and not started")
      ->Excludes(out);
  gw::cli::Command* const prepare = app.AddCommand("prepare", "one job: makes the log of an input");
  gw::cli::Command* const run =
      app.AddCommand("run-job", "one job: runs gw-slam once on an input that is prepared");
  gw::cli::Command* const collect =
      app.AddCommand("collect", "one job: tables and plots of what has been run");
  for (gw::cli::Command* const sub : {prepare, run, collect}) gw::bench::AddOptions(sub, &args);
  for (gw::cli::Command* const sub : {prepare, run}) {
    sub->AddOption("--input", args.cell.input, "its name in the suite")->Required();
  }
  run->AddOption("--variant", args.cell.variant, "as the suite names it")->Required();
  run->AddOption("--seed", args.cell.seed, "which perturbed start, from 0")->Required();
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  if (args.suite.empty()) return app.Missing("suite");
  if (args.out.empty() && args.workflow.empty()) return app.Missing("--out or --workflow");
  gw::bench::Command command = gw::bench::RunAll;
  if (!args.workflow.empty()) command = gw::bench::WriteWorkflow;
  if (prepare->given()) command = gw::bench::PrepareOne;
  if (run->given()) command = gw::bench::RunJob;
  if (collect->given()) command = gw::bench::Collect;
  const auto done = gw::bench::RunCommand(args, command);
  if (done) return gw::kExitOk;
  std::fprintf(stderr, "gw-bench: %s\n", done.error().message.c_str());
  return gw::ExitCodeFor(done.error());
}

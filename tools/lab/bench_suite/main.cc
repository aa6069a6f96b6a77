// gw-bench: every input x every variant x every run of a suite, and the tables that come of it.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <regex>
#include <string>

#include "common/core/exit_code.h"
#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/report.h"

namespace gw::bench {
namespace {

struct Arguments {
  std::string suite;
  std::string out;
  std::string cache;
  std::string data;
  std::string filter;
  int runs = 0;  // 0: as the suite says
  int jobs = 1;
};

Result<Done> MakeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  return Done{};
}

// Leaves the cells whose "INPUT VARIANT" matches.
Result<std::vector<std::pair<const SuiteInput*, std::string>>> Select(const Suite& suite,
                                                                      const std::string& filter) {
  std::vector<std::pair<const SuiteInput*, std::string>> out;
  try {
    const std::regex pattern(filter);
    for (const SuiteInput& input : suite.inputs) {
      for (const std::string& variant : suite.variants) {
        if (std::regex_search(input.name + " " + variant, pattern))
          out.emplace_back(&input, variant);
      }
    }
  } catch (const std::regex_error& e) {
    return Error{ErrorCode::kInvalidArgument, "--filter " + filter + ": " + e.what()};
  }
  if (out.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--filter " + filter + ": matches no \"INPUT VARIANT\" of the suite"};
  }
  return out;
}

Result<std::vector<CellResult>> RunAll(const Arguments& args, const Suite& suite) {
  const auto selected = Select(suite, args.filter);
  if (!selected) return selected.error();
  std::vector<PreparedInput> inputs;
  inputs.reserve(suite.inputs.size());  // the cells point into it
  std::vector<Cell> cells;
  for (const auto& [input, variant] : *selected) {
    if (inputs.empty() || inputs.back().name != input->name) {
      auto prepared = PrepareInput(*input, args.cache);
      if (!prepared) {
        return Error{prepared.error().code, input->name + ": " + prepared.error().message};
      }
      inputs.push_back(*std::move(prepared));
    }
    for (int seed = 0; seed < suite.runs; ++seed) cells.push_back({&inputs.back(), variant, seed});
  }
  size_t done = 0;
  const auto finished = [&](const CellResult& r, bool was_there) {
    std::string numbers = r.failure;
    if (r.measures) {
      const auto& ape = r.measures->ape_live_m;
      numbers = "APE " + (ape ? FormatFixed(*ape, 4) + " m" : "-") + ", lost " +
                std::to_string(r.measures->lost) + ", blind " + std::to_string(r.measures->blind);
    }
    std::fprintf(stderr, "gw-bench: %zu/%zu %s %s seed %d%s: %s\n", ++done, cells.size(),
                 r.input.c_str(), r.variant.c_str(), r.seed, was_there ? " (was there)" : "",
                 numbers.c_str());
  };
  return RunCells(cells, {args.out, args.jobs, suite.alignment}, finished);
}

Result<Done> Run(Arguments args) {
  auto suite = LoadSuite(args.suite, args.data);
  if (!suite) return suite.error();
  if (args.runs > 0) suite->runs = args.runs;
  for (const SuiteInput& input : suite->inputs) {
    if (input.source == Source::kImport && !std::filesystem::is_directory(input.path)) {
      return Error{ErrorCode::kNotFound, input.name + ": no recording " + input.path +
                                             "; --data names the folder that holds it"};
    }
  }
  if (args.cache.empty()) args.cache = args.out + "/cache";
  for (const std::string& folder : {args.out, args.cache}) {
    const auto made = MakeFolder(folder);
    if (!made) return made.error();
  }
  auto results = RunAll(args, *suite);
  if (!results) return results.error();
  const BenchReport report{*std::move(suite), args.jobs, *std::move(results)};
  const std::string table = RenderMarkdown(report);
  const std::pair<const char*, std::string> files[] = {{"table.md", table},
                                                       {"table.csv", RenderCsv(report)},
                                                       {"ranking.svg", RenderRankingPlot(report)},
                                                       {"inputs.svg", RenderInputsPlot(report)}};
  for (const auto& [name, text] : files) {
    const auto written = tools::WriteTextFile(args.out + "/" + name, text);
    if (!written) return written.error();
  }
  std::fputs(table.c_str(), stdout);
  for (const CellResult& r : report.results) {
    if (!r.measures) {
      return Error{ErrorCode::kBadData, "some runs of gw-slam failed, see the end of the table"};
    }
  }
  return Done{};
}

}  // namespace
}  // namespace gw::bench

int main(int argc, char** argv) {
  gw::bench::Arguments args;
  CLI::App app(
      "Runs gw-slam on every input of a suite with every variant, several times with perturbed "
      "starts,\nand writes table.md, table.csv, ranking.svg and inputs.svg. Cells that are "
      "finished "
      "are not run\nagain while gw-slam, log and configuration stay the same.\n"
      "Exit: 0 ok, 1 failed, 2 usage, 78 bad suite or scenario.");
  app.set_version_flag("--version", gw::Version());
  app.add_option("suite", args.suite, "suite file (YAML, config/suites)")->required();
  app.add_option("--out", args.out, "folder for tables, plots and runs")->required();
  app.add_option("--runs", args.runs, "runs per input and variant, in place of the suite's")
      ->check(CLI::Range(1, 100));
  app.add_option("--jobs", args.jobs, "runs at the same time (1); more disturb the timings")
      ->check(CLI::Range(1, 64));
  app.add_option("--filter", args.filter,
                 "regular expression: only where it matches \"INPUT VARIANT\"");
  app.add_option("--cache", args.cache, "folder for rendered and imported logs (OUT/cache)");
  app.add_option("--data", args.data, "folder that holds the suite's recordings");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? gw::kExitOk : gw::kExitUsage;
  }
  const auto done = gw::bench::Run(args);
  if (done) return gw::kExitOk;
  std::fprintf(stderr, "gw-bench: %s\n", done.error().message.c_str());
  return gw::ExitCodeFor(done.error());
}

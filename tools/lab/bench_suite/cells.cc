#include "tools/lab/bench_suite/cells.h"

#include <algorithm>
#include <filesystem>
#include <regex>

#include "tools/data/files/hash_file.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/programs.h"

namespace gw::bench {
namespace {

namespace fs = std::filesystem;

// What a cell's result depends on.
std::string KeyOf(const Cell& cell, const PreparedInput& input, const KeptSlam& slam) {
  return "gw-slam " + slam.hash + "\nlog " + input.log_hash + "\nconfig " + input.config_hash +
         "\nvariant " + cell.variant + "\nseed " + std::to_string(cell.seed) + "\n";
}

bool Finished(const Cell& cell, const PreparedInput& input, const KeptSlam& slam,
              const std::string& out) {
  const auto key = tools::ReadTextFile(out + "/" + CellFolder(cell) + "/key");
  return key.ok() && *key == KeyOf(cell, input, slam);
}

}  // namespace

Result<std::vector<Cell>> SelectCells(const Suite& suite, const std::string& filter) {
  std::vector<Cell> out;
  try {
    const std::regex pattern(filter);
    for (const SuiteInput& input : suite.inputs) {
      for (const std::string& variant : suite.variants) {
        if (!std::regex_search(input.name + " " + variant, pattern)) continue;
        for (int seed = 0; seed < suite.runs; ++seed) out.push_back({input.name, variant, seed});
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

Result<Done> KeepSlam(const std::string& out) {
  const auto path = SiblingProgram("gw-slam");
  if (!path) return path.error();
  const auto hash = tools::HashFile(*path);
  if (!hash) return hash.error();
  const auto kept = FindSlam(out);
  if (kept && kept->hash == tools::HashText(*hash)) return Done{};
  // A job that runs keeps the file it has opened: the new one takes its name only when complete.
  const std::string copy = out + "/gw-slam";
  std::error_code error;
  fs::copy_file(*path, copy + ".part", fs::copy_options::overwrite_existing, error);
  if (!error) fs::rename(copy + ".part", copy, error);
  if (error) return Error{ErrorCode::kIo, copy + ": cannot be made: " + error.message()};
  return Done{};
}

Result<KeptSlam> FindSlam(const std::string& out) {
  const std::string path = fs::absolute(out + "/gw-slam");
  const auto hash = tools::HashFile(path);
  if (!hash) return hash.error();
  return KeptSlam{path, tools::HashText(*hash)};
}

std::string VariantFolder(const std::string& variant) {
  std::string folder = variant;
  std::replace(folder.begin(), folder.end(), ':', '-');
  return folder;
}

std::string CellFolder(const Cell& cell) {
  return "cells/" + cell.input + "/" + VariantFolder(cell.variant) + "/seed-" +
         std::to_string(cell.seed);
}

Result<bool> RunCell(const Cell& cell, const PreparedInput& input, const KeptSlam& slam,
                     const std::string& out) {
  if (Finished(cell, input, slam, out)) return true;
  const std::string folder = fs::absolute(out + "/" + CellFolder(cell));
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  fs::remove(folder + "/key", error);
  const auto done = RunProgram(
      {slam.path, input.log, "--config", input.config, "--out", folder, "--variant", cell.variant,
       "--seed", std::to_string(cell.seed), "--timing", folder + "/timing.csv"},
      folder + "/output.txt");
  if (!done) return done.error();
  const auto written = tools::WriteTextFile(folder + "/key", KeyOf(cell, input, slam));
  if (!written) return written.error();
  return false;
}

CellResult ReadCell(const Cell& cell, const PreparedInput& input, const eval::Trajectory& truth,
                    eval::Alignment alignment, const KeptSlam& slam, const std::string& out) {
  CellResult result;
  result.input = cell.input;
  result.variant = cell.variant;
  result.seed = cell.seed;
  result.log = fs::path(input.log).filename().string();
  result.log_hash = input.log_hash;
  result.slam_hash = slam.hash;
  if (!Finished(cell, input, slam, out)) {
    result.failure = "not finished, see " + CellFolder(cell) + "/output.txt";
    return result;
  }
  const std::string folder = out + "/" + CellFolder(cell);
  const auto stored = measure::ReadRun(folder, folder + "/timing.csv");
  if (!stored) {
    result.failure = stored.error().message;
    return result;
  }
  result.origin = stored->origin;
  result.measures = measure::Measure(stored->run, truth, alignment);
  return result;
}

}  // namespace gw::bench

#include "tools/lab/bench_suite/cells.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>

#include "tools/data/files/hash_file.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/programs.h"

namespace gw::bench {
namespace {

namespace fs = std::filesystem;

struct Slam {
  std::string path;
  std::string hash;
};

// A copy of gw-slam, so that a build meanwhile does not mix two versions in one table.
Result<Slam> TakeSlam(const std::string& folder) {
  const auto path = SiblingProgram("gw-slam");
  if (!path) return path.error();
  const std::string copy = folder + "/gw-slam";
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) fs::copy_file(*path, copy, fs::copy_options::overwrite_existing, error);
  if (error) return Error{ErrorCode::kIo, copy + ": cannot be made: " + error.message()};
  const auto hash = tools::HashFile(copy);
  if (!hash) return hash.error();
  return Slam{copy, tools::HashText(*hash)};
}

// What a cell's result depends on.
std::string KeyOf(const Cell& cell, const Slam& slam) {
  return "gw-slam " + slam.hash + "\nlog " + cell.input->log_hash + "\nconfig " +
         cell.input->config_hash + "\nvariant " + cell.variant + "\nseed " +
         std::to_string(cell.seed) + "\n";
}

std::string FolderOf(const Cell& cell, const std::string& out) {
  std::string variant = cell.variant;
  std::replace(variant.begin(), variant.end(), ':', '-');
  return out + "/cells/" + cell.input->name + "/" + variant + "/seed-" + std::to_string(cell.seed);
}

// Leaves the outputs of gw-slam and then the key in the folder.
Result<Done> Run(const Cell& cell, const Slam& slam, const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  fs::remove(folder + "/key", error);
  const auto done = RunProgram(
      {slam.path, cell.input->log, "--config", cell.input->config, "--out", folder, "--variant",
       cell.variant, "--seed", std::to_string(cell.seed), "--timing", folder + "/timing.csv"},
      folder + "/output.txt");
  if (!done) return done.error();
  return tools::WriteTextFile(folder + "/key", KeyOf(cell, slam));
}

CellResult ResultOf(const Cell& cell, const Slam& slam, const CellOptions& options,
                    bool* was_there) {
  CellResult result;
  result.input = cell.input->name;
  result.variant = cell.variant;
  result.seed = cell.seed;
  result.log = fs::path(cell.input->log).filename().string();
  result.log_hash = cell.input->log_hash;
  result.slam_hash = slam.hash;
  const std::string folder = FolderOf(cell, options.out);
  const auto key = tools::ReadTextFile(folder + "/key");
  *was_there = key.ok() && *key == KeyOf(cell, slam);
  if (!*was_there) {
    const auto done = Run(cell, slam, folder);
    if (!done) {
      result.failure = done.error().message;
      return result;
    }
  }
  const auto stored = measure::ReadRun(folder, folder + "/timing.csv");
  if (!stored) {
    result.failure = stored.error().message;
    return result;
  }
  result.origin = stored->origin;
  result.measures = measure::Measure(stored->run, cell.input->truth, options.alignment);
  return result;
}

}  // namespace

Result<std::vector<CellResult>> RunCells(
    const std::vector<Cell>& cells, const CellOptions& options,
    const std::function<void(const CellResult& result, bool was_there)>& finished) {
  const auto slam = TakeSlam(options.out);
  if (!slam) return slam.error();
  std::vector<CellResult> results(cells.size());
  std::atomic<size_t> next = 0;
  std::mutex reporting;
  const auto work = [&] {
    for (size_t i = next++; i < cells.size(); i = next++) {
      bool was_there = false;
      results[i] = ResultOf(cells[i], *slam, options, &was_there);
      const std::lock_guard lock(reporting);
      finished(results[i], was_there);
    }
  };
  std::vector<std::thread> workers;
  for (int i = 1; i < options.jobs; ++i) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  return results;
}

}  // namespace gw::bench

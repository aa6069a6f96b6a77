#include "tools/lab/bench_suite/inputs.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "common/core/hash.h"
#include "tools/data/files/hash_file.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/programs.h"

namespace gw::bench {
namespace {

namespace fs = std::filesystem;

// Hashes texts with their borders.
class RecipeHash {
 public:
  void Add(const std::string& text) {
    hash_ = Fnv1a(text, hash_);
    hash_ = Fnv1a(std::string_view("\0", 1), hash_);
  }
  void Add(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) Add(text);
  }
  std::string text() const { return tools::HashText(hash_); }

 private:
  uint64_t hash_ = kFnvOffset;
};

// The scenario and all files beside its map.
Result<std::string> ScenarioRecipe(const SuiteInput& input) {
  RecipeHash hash;
  const auto scenario = tools::ReadTextFile(input.path);
  if (!scenario) return scenario.error();
  hash.Add(*scenario);
  hash.Add(input.options);
  try {
    const YAML::Node map = YAML::Load(*scenario)["map"];
    if (map.IsDefined()) {
      const fs::path folder = (fs::path(input.path).parent_path() / map.Scalar()).parent_path();
      std::vector<std::string> files;
      for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
      std::sort(files.begin(), files.end());
      for (const std::string& file : files) {
        const auto text = tools::ReadTextFile(file);
        if (!text) return text.error();
        hash.Add(*text);
      }
    }
  } catch (const std::exception& e) {  // of YAML or the file system; gw-sim would say the same
    return Error{ErrorCode::kBadConfig, input.path + ": " + e.what()};
  }
  return hash.text();
}

Result<Done> RunVerbosely(const std::vector<std::string>& command, const std::string& output) {
  std::string line;
  for (const std::string& word : command) line += (line.empty() ? "" : " ") + word;
  std::fprintf(stderr, "gw-bench: %s\n", line.c_str());
  return RunProgram(command, output);
}

// Renders or imports, unless it is there.
Result<Done> MakeLog(const SuiteInput& input, const std::string& cache, std::string* log,
                     std::string* config) {
  const bool render = input.source == Source::kScenario;
  std::string recipe;
  if (render) {
    auto hash = ScenarioRecipe(input);
    if (!hash) return hash.error();
    recipe = *std::move(hash);
  } else {
    RecipeHash hash;
    hash.Add(input.format);
    hash.Add(input.path);
    hash.Add(input.options);
    recipe = hash.text();
  }
  const std::string base = cache + "/" + fs::path(input.path).stem().string() + "-" + recipe;
  *log = base + ".lcm";
  *config = base + ".yaml";
  if (fs::exists(*log) && fs::exists(*config)) return Done{};
  const auto program = SiblingProgram(render ? "gw-sim" : "gw-import");
  if (!program) return program.error();
  std::vector<std::string> command = {*program};
  if (render) {
    command.insert(command.end(), {"--scenario", input.path, "--log", *log});
  } else {
    command.insert(command.end(), {input.format, input.path, "--out", *log});
  }
  command.insert(command.end(), {"--config-out", *config});
  command.insert(command.end(), input.options.begin(), input.options.end());
  return RunVerbosely(command, base + ".out");
}

Result<Done> ApplyFaults(const SuiteInput& input, const std::string& cache, std::string* log) {
  RecipeHash hash;
  hash.Add(fs::path(*log).filename().string());
  hash.Add(input.fault);
  const std::string base = cache + "/" + input.name + "-" + hash.text();
  const std::string edited = base + ".lcm";
  if (!fs::exists(edited)) {
    const auto program = SiblingProgram("gw-fault");
    if (!program) return program.error();
    std::vector<std::string> command = {*program, *log, edited};
    command.insert(command.end(), input.fault.begin(), input.fault.end());
    const auto done = RunVerbosely(command, base + ".out");
    if (!done) return done.error();
  }
  *log = edited;
  return Done{};
}

}  // namespace

Result<PreparedInput> PrepareInput(const SuiteInput& input, const std::string& cache) {
  PreparedInput out;
  out.name = input.name;
  if (input.source == Source::kLog) {
    out.log = input.path;
    out.config = input.config;
  } else {
    const auto made = MakeLog(input, cache, &out.log, &out.config);
    if (!made) return made.error();
  }
  if (!input.fault.empty()) {
    const auto edited = ApplyFaults(input, cache, &out.log);
    if (!edited) return edited.error();
  }
  const auto log_hash = tools::HashFile(out.log);
  if (!log_hash) return log_hash.error();
  out.log_hash = tools::HashText(*log_hash);
  const auto config_hash = tools::HashFile(out.config);
  if (!config_hash) return config_hash.error();
  out.config_hash = tools::HashText(*config_hash);
  auto truth = eval::ReadGroundTruthLog(out.log);
  if (!truth) return truth.error();
  out.truth = *std::move(truth);
  return out;
}

}  // namespace gw::bench

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
Result<std::vector<std::string>> ScenarioFiles(const std::string& scenario) {
  std::vector<std::string> files = {scenario};
  const auto text = tools::ReadTextFile(scenario);
  if (!text) return text.error();
  try {
    const YAML::Node map = YAML::Load(*text)["map"];
    if (map.IsDefined()) {
      const fs::path folder = (fs::path(scenario).parent_path() / map.Scalar()).parent_path();
      for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
      std::sort(files.begin() + 1, files.end());
    }
  } catch (const std::exception& e) {  // of YAML or the file system; gw-sim would say the same
    return Error{ErrorCode::kBadConfig, scenario + ": " + e.what()};
  }
  return files;
}

Result<std::string> ScenarioRecipe(const SuiteInput& input) {
  const auto files = ScenarioFiles(input.path);
  if (!files) return files.error();
  RecipeHash hash;
  for (const std::string& file : *files) {
    const auto text = tools::ReadTextFile(file);
    if (!text) return text.error();
    hash.Add(*text);
    if (file == input.path) hash.Add(input.options);
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

// The robot YAML with the input's settings, as a file of its own.
Result<Done> ApplySettings(const SuiteInput& input, const std::string& cache, std::string* config) {
  RecipeHash hash;
  const auto text = tools::ReadTextFile(*config);
  if (!text) return text.error();
  hash.Add(*text);
  try {
    YAML::Node root = YAML::Load(*text);
    for (const auto& [key, value] : input.set) {
      hash.Add(key);
      hash.Add(value);
      YAML::Node node = root;
      size_t begin = 0;
      for (size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', begin)) {
        node.reset(node[key.substr(begin, dot - begin)]);
        begin = dot + 1;
      }
      node[key.substr(begin)] = value;
    }
    YAML::Emitter yaml;
    yaml << root << YAML::Newline;
    *config = cache + "/" + input.name + "-" + hash.text() + ".yaml";
    return tools::WriteTextFile(*config, yaml.c_str());
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig, *config + ": " + e.what()};
  }
}

std::string NoteOf(const std::string& name, const std::string& out) {
  return out + "/inputs/" + name + ".yaml";
}

Result<Done> WriteNote(const PreparedInput& input, const std::string& out) {
  YAML::Emitter yaml;
  yaml << YAML::BeginMap << YAML::Key << "log" << YAML::Value << input.log << YAML::Key
       << "log_hash" << YAML::Value << input.log_hash << YAML::Key << "config" << YAML::Value
       << input.config << YAML::Key << "config_hash" << YAML::Value << input.config_hash
       << YAML::EndMap << YAML::Newline;
  const std::string path = NoteOf(input.name, out);
  const auto there = tools::ReadTextFile(path);
  if (there && *there == yaml.c_str()) return Done{};
  std::error_code error;
  fs::create_directories(out + "/inputs", error);
  return tools::WriteTextFile(path, yaml.c_str());
}

}  // namespace

std::vector<std::string> SourcesOf(const SuiteInput& input) {
  switch (input.source) {
    case Source::kLog:
      return {input.path, input.config};
    case Source::kImport:
      return {input.path};
    case Source::kScenario:
      break;
  }
  const auto files = ScenarioFiles(input.path);
  return files ? *files : std::vector<std::string>{input.path};
}

Result<PreparedInput> PrepareInput(const SuiteInput& input, const std::string& cache,
                                   const std::string& out) {
  PreparedInput prepared;
  prepared.name = input.name;
  if (input.source == Source::kLog) {
    prepared.log = fs::absolute(input.path);
    prepared.config = fs::absolute(input.config);
  } else {
    const auto made = MakeLog(input, fs::absolute(cache), &prepared.log, &prepared.config);
    if (!made) return made.error();
  }
  if (!input.fault.empty()) {
    const auto edited = ApplyFaults(input, fs::absolute(cache), &prepared.log);
    if (!edited) return edited.error();
  }
  if (!input.set.empty()) {
    const auto set = ApplySettings(input, fs::absolute(cache), &prepared.config);
    if (!set) return set.error();
  }
  const auto log_hash = tools::HashFile(prepared.log);
  if (!log_hash) return log_hash.error();
  prepared.log_hash = tools::HashText(*log_hash);
  const auto config_hash = tools::HashFile(prepared.config);
  if (!config_hash) return config_hash.error();
  prepared.config_hash = tools::HashText(*config_hash);
  const auto noted = WriteNote(prepared, out);
  if (!noted) return noted.error();
  return prepared;
}

Result<PreparedInput> ReadPreparedInput(const std::string& name, const std::string& out) {
  const std::string path = NoteOf(name, out);
  const auto text = tools::ReadTextFile(path);
  if (!text) {
    return Error{text.error().code,
                 name + " is not prepared (gw-bench prepare): " + text.error().message};
  }
  try {
    const YAML::Node note = YAML::Load(*text);
    const auto field = [&](const char* key) { return note[key].as<std::string>(); };
    return PreparedInput{name, field("log"), field("config"), field("log_hash"),
                         field("config_hash")};
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadData, path + ": " + e.what()};
  }
}

}  // namespace gw::bench

#include "tools/lab/bench_suite/find.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "tools/data/files/text_file.h"

namespace gw::bench {
namespace {

namespace fs = std::filesystem;

bool HasWheels(const fs::path& sequence) {
  const auto text = tools::ReadTextFile(sequence / "odom.txt");
  if (!text) return false;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    const size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && line[first] != '#') return true;
  }
  return false;
}

Result<std::string> CalibrationOf(const fs::path& sequence, const fs::path& data) {
  for (fs::path folder = sequence;; folder = folder.parent_path()) {
    if (fs::exists(folder / "calibration.yaml")) return (folder / "calibration.yaml").string();
    if (folder == data || folder == folder.parent_path()) break;
  }
  return Error{ErrorCode::kNotFound,
               sequence.string() +
                   ": no calibration.yaml there or above; put the data set's into " +
                   data.string()};
}

Result<std::vector<fs::path>> SequencesIn(const fs::path& data) {
  std::vector<fs::path> out;
  std::error_code error;
  // Symbolic links are followed: recordings often lie on another disk.
  const auto options = fs::directory_options::follow_directory_symlink |
                       fs::directory_options::skip_permission_denied;
  fs::recursive_directory_iterator it(data, options, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name == "color" || name == "depth") it.disable_recursion_pending();  // images
    if (name == "associations.txt") out.push_back(it->path().parent_path());
  }
  if (error) return Error{ErrorCode::kNotFound, data.string() + ": " + error.message()};
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Result<Done> FindCidSims(const CidSimsSearch& search, const std::string& data,
                         std::vector<SuiteInput>* inputs, std::vector<std::string>* left_out) {
  if (data.empty()) {
    return Error{ErrorCode::kNotFound, "--data names the folder that holds the sequences"};
  }
  const fs::path folder = fs::absolute(data).lexically_normal();
  const auto sequences = SequencesIn(folder);
  if (!sequences) return sequences.error();
  if (sequences->empty()) {
    return Error{
        ErrorCode::kNotFound,
        folder.string() + ": no sequence of CID-SIMS in it (folders with associations.txt)"};
  }
  for (const fs::path& sequence : *sequences) {
    const std::string name = sequence.filename().string();
    if (!HasWheels(sequence)) {
      left_out->push_back(name);
      continue;
    }
    const auto calibration = CalibrationOf(sequence, folder);
    if (!calibration) return calibration.error();
    const bool low = std::find(search.low.begin(), search.low.end(), name) != search.low.end();
    SuiteInput input;
    input.name = name;
    input.source = Source::kImport;
    input.path = sequence.string();
    input.format = "cid-sims";
    input.options = {"--mount", low ? "low" : "high", "--calibration", *calibration};
    inputs->push_back(std::move(input));
  }
  return Done{};
}

}  // namespace gw::bench

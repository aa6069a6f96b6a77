// Reads YAML mappings strictly: unknown and duplicate keys, missing keys, wrong types and values
// out of range are mistakes, collected with file and line, so that a user sees all of them at once.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <utility>
#include <vector>

namespace gw::tools {

class YamlReport {
 public:
  explicit YamlReport(std::string file) : file_(std::move(file)) {}
  void Add(const YAML::Node& node, const std::string& what);
  bool empty() const { return lines_.empty(); }
  // One mistake a line, sorted by line of the file.
  std::string Text() const;

 private:
  std::string file_;
  std::vector<std::pair<int, std::string>> lines_;
};

// One mapping. Ask for all keys that may be there, then call Finish.
class StrictMap {
 public:
  StrictMap(const YAML::Node& node, std::string path, YamlReport* report);

  // Each leaves `value` alone when the key is not there (a mistake if it is required) or wrong.
  void Number(const char* key, double* value, double min, double max, bool required = false);
  void Integer(const char* key, int* value, int min, int max, bool required = false);
  void Flag(const char* key, bool* value);
  void Text(const char* key, std::string* value, bool required = false);
  // Exactly `count` finite numbers.
  void Numbers(const char* key, std::vector<double>* values, size_t count, bool required = false);
  template <typename E>
  void Choice(const char* key, E* value, const std::vector<std::pair<const char*, E>>& choices,
              bool required = false) {
    const YAML::Node node = Take(key, required);
    if (!node.IsDefined()) return;
    std::string names;
    for (const auto& [name, choice] : choices) {
      if (node.IsScalar() && node.Scalar() == name) {
        *value = choice;
        return;
      }
      names += (names.empty() ? "" : ", ") + std::string(name);
    }
    report_->Add(node, PathOf(key) + ": must be one of " + names);
  }
  // The node of a key, for what needs its own reading; not defined when it is not there.
  YAML::Node Take(const char* key, bool required = false);
  // What nobody asked for is a mistake.
  void Finish();

  std::string PathOf(const std::string& key) const {
    return path_.empty() ? key : path_ + "." + key;
  }
  YamlReport* report() const { return report_; }
  const YAML::Node& node() const { return node_; }

 private:
  YAML::Node node_;
  std::string path_;
  YamlReport* report_;
  std::vector<std::string> known_;
};

// A sequence of `count` finite numbers, or a mistake. What it is for: `path`.
bool ReadNumbers(const YAML::Node& node, const std::string& path, size_t count, YamlReport* report,
                 std::vector<double>* values);

}  // namespace gw::tools

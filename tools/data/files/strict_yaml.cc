#include "tools/data/files/strict_yaml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "common/core/format.h"

namespace gw::tools {
namespace {

template <typename Number>
bool Parse(const YAML::Node& node, Number* value) {
  if (!node.IsScalar() || node.Tag() == "!") return false;  // "!" marks quoted text
  const std::string& text = node.Scalar();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

void YamlReport::Add(const YAML::Node& node, const std::string& what) {
  lines_.emplace_back(std::max(0, node.Mark().line) + 1, what);
}

std::string YamlReport::Text() const {
  std::vector<std::pair<int, std::string>> sorted = lines_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text;
  for (const auto& [line, what] : sorted) {
    text += (text.empty() ? "" : "\n") + file_ + ":" + std::to_string(line) + ": " + what;
  }
  return text;
}

StrictMap::StrictMap(const YAML::Node& node, std::string path, YamlReport* report)
    : node_(node), path_(std::move(path)), report_(report) {
  if (!node_.IsMap()) {
    report_->Add(node_, (path_.empty() ? "file" : path_) + ": must be `key: value` lines");
    return;
  }
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (!seen.insert(key).second) report_->Add(entry.first, PathOf(key) + ": duplicate key");
  }
}

YAML::Node StrictMap::Take(const char* key, bool required) {
  known_.emplace_back(key);
  if (node_.IsMap()) {
    for (const auto& entry : node_) {
      if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.second;
    }
  }
  if (required) report_->Add(node_, PathOf(key) + ": missing, add it");
  return YAML::Node(YAML::NodeType::Undefined);
}

void StrictMap::Number(const char* key, double* value, double min, double max, bool required) {
  const YAML::Node node = Take(key, required);
  if (!node.IsDefined()) return;
  double parsed = 0;
  if (!Parse(node, &parsed) || !std::isfinite(parsed) || parsed < min || parsed > max) {
    report_->Add(node, PathOf(key) + ": must be a number from " + FormatDouble(min) + " to " +
                           FormatDouble(max));
    return;
  }
  *value = parsed;
}

void StrictMap::Integer(const char* key, int* value, int min, int max, bool required) {
  const YAML::Node node = Take(key, required);
  if (!node.IsDefined()) return;
  int parsed = 0;
  if (!Parse(node, &parsed) || parsed < min || parsed > max) {
    report_->Add(node, PathOf(key) + ": must be a whole number from " + std::to_string(min) +
                           " to " + std::to_string(max));
    return;
  }
  *value = parsed;
}

void StrictMap::Flag(const char* key, bool* value) {
  const YAML::Node node = Take(key);
  if (!node.IsDefined()) return;
  if (!node.IsScalar() || (node.Scalar() != "true" && node.Scalar() != "false")) {
    report_->Add(node, PathOf(key) + ": must be true or false");
    return;
  }
  *value = node.Scalar() == "true";
}

void StrictMap::Text(const char* key, std::string* value, bool required) {
  const YAML::Node node = Take(key, required);
  if (!node.IsDefined()) return;
  if (!node.IsScalar() || node.Scalar().empty()) {
    report_->Add(node, PathOf(key) + ": must be text");
    return;
  }
  *value = node.Scalar();
}

void StrictMap::Numbers(const char* key, std::vector<double>* values, size_t count, bool required) {
  const YAML::Node node = Take(key, required);
  if (node.IsDefined()) ReadNumbers(node, PathOf(key), count, report_, values);
}

void StrictMap::Finish() {
  if (!node_.IsMap()) return;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string names;
    for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
    report_->Add(entry.first, PathOf(key) + ": no such key; here may stand: " + names);
  }
}

bool ReadNumbers(const YAML::Node& node, const std::string& path, size_t count, YamlReport* report,
                 std::vector<double>* values) {
  std::vector<double> out;
  if (node.IsSequence()) {
    for (const auto& element : node) {
      double value = 0;
      if (!Parse(element, &value) || !std::isfinite(value)) break;
      out.push_back(value);
    }
  }
  if (!node.IsSequence() || out.size() != count || node.size() != count) {
    report->Add(node, path + ": must be a list of " + std::to_string(count) + " numbers");
    return false;
  }
  *values = std::move(out);
  return true;
}

}  // namespace gw::tools

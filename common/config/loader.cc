#include "common/config/loader.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "common/config/reference.h"
#include "common/config/validate.h"
#include "common/core/format.h"

namespace gw {
namespace {

constexpr double kQuaternionNormTolerance = 1e-3;

int LineOf(const YAML::Mark& mark) {
  return mark.line + 1;  // yaml-cpp counts from 0; -1 stands for "unknown"
}

// The value as the file states it, short enough for one line.
std::string ValueText(const YAML::Node& node) {
  if (node.IsSequence()) return "[...]";
  if (node.IsMap()) return "{...}";
  if (!node.IsScalar()) return "(nothing)";
  std::string text = node.Scalar();
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return node.Tag() == "!" ? '"' + text + '"' : text;
}

// A plain scalar's text; empty for anything else, also for quoted and explicitly tagged text.
std::optional<std::string> PlainText(const YAML::Node& node) {
  if (!node.IsScalar() || node.Tag() != "?") return std::nullopt;
  return node.Scalar();
}

template <typename Number>
bool ParseNumber(const std::string& text, Number* value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [parsed_to, error] = std::from_chars(begin, end, *value);
  return error == std::errc() && parsed_to == end;
}

bool IsBool(const std::string& text) {
  return text == "true" || text == "false";
}

bool LooksLikeAnotherType(const std::string& text) {
  double ignored = 0;
  return IsBool(text) || text == "null" || text == "~" || ParseNumber(text, &ignored);
}

int EditDistance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const int substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

// What the whole file shares while it is read: the mistakes so far, and where each key stands.
class Report {
 public:
  explicit Report(std::string file) : file_(std::move(file)) {}

  void Add(int line, const std::string& what) { lines_.emplace_back(line, what); }
  void Remember(const std::string& key, int line, const std::string& value) {
    places_[key] = {line, value};
  }
  bool empty() const { return lines_.empty(); }
  bool HasMistakeIn(const std::string& section) const {
    return std::any_of(lines_.begin(), lines_.end(), [&](const auto& line) {
      return line.second.compare(0, section.size(), section) == 0;
    });
  }

  // A broken cross-field rule, at the key if the file has it, else at the section around it.
  void AddRule(const RuleViolation& violation) {
    std::string key = violation.key;
    const auto exact = places_.find(key);
    const bool has_value = exact != places_.end() && !exact->second.value.empty();
    while (places_.count(key) == 0 && key.find('.') != std::string::npos) {
      key.resize(key.rfind('.'));
    }
    const auto place = places_.find(key);
    Add(place == places_.end() ? 1 : place->second.line,
        violation.key + (has_value ? " = " + exact->second.value : "") + ": " + violation.rule);
  }

  Error ToError() {
    std::stable_sort(lines_.begin(), lines_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::string message;
    for (const auto& [line, what] : lines_) {
      if (!message.empty()) message += '\n';
      message += file_ + ":" + std::to_string(line) + ": " + what;
    }
    return {ErrorCode::kBadConfig, message};
  }

 private:
  struct Place {
    int line = 1;
    std::string value;  // empty for sections
  };
  std::string file_;
  std::vector<std::pair<int, std::string>> lines_;
  std::map<std::string, Place> places_;
};

// The visitor that fills one section from one YAML mapping.
class SectionReader {
 public:
  SectionReader(const YAML::Node& node, std::string path, int line, Report* report)
      : path_(std::move(path)), line_(line), report_(report) {
    if (node.IsNull()) return;  // a section whose keys are all commented out
    if (!node.IsMap()) {
      report_->Add(line_, (path_.empty() ? "file" : path_) + " = " + ValueText(node) +
                              ": must be a section, write `key: value` lines");
      readable_ = false;
      return;
    }
    for (const auto& pair : node) ReadEntry(pair.first, pair.second);
  }

  void Field(const char* name, bool& value, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    const auto text = PlainText(entry->value);
    if (!text || !IsBool(*text)) return Bad(*entry, "must be a bool, write true or false");
    value = *text == "true";
  }

  void Field(const char* name, int& value, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    const auto text = PlainText(entry->value);
    int64_t parsed = 0;
    if (!text || !ParseNumber(*text, &parsed)) {
      return Bad(*entry, "must be an int, write digits without point, exponent or quotes");
    }
    const double low = std::max<double>(spec.min, std::numeric_limits<int>::min());
    const double high = std::min<double>(spec.max, std::numeric_limits<int>::max());
    const auto as_double = static_cast<double>(parsed);
    if (as_double < low || as_double > high) return OutOfRange(*entry, spec);
    value = static_cast<int>(parsed);
  }

  void Field(const char* name, double& value, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    if (const auto parsed = ReadDouble(*entry, spec)) value = *parsed;
  }

  void Field(const char* name, std::string& value, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    if (!entry->value.IsScalar()) return Bad(*entry, "must be text");
    const std::string text = entry->value.Scalar();
    if (PlainText(entry->value) && LooksLikeAnotherType(text)) {
      return Bad(*entry, "must be text, put it in quotes");
    }
    if (text.empty()) return Bad(*entry, "must not be empty");
    value = text;
  }

  template <size_t N>
  void Field(const char* name, std::array<double, N>& value, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    if (const auto parsed = ReadDoubles<N>(*entry, spec)) value = *parsed;
  }

  template <typename E>
  void Enum(const char* name, E& value, const EnumChoices<E>& choices, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    std::vector<std::string> names;
    for (const auto& [text, choice] : choices) {
      if (entry->value.IsScalar() && entry->value.Scalar() == text) {
        value = choice;
        return;
      }
      names.emplace_back(text);
    }
    Bad(*entry, "no such choice, write " + JoinChoices(names));
  }

  void Pose(const char* name, SE3& value, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    if (!entry->value.IsMap()) {
      return Bad(*entry, "must be a pose, write {p: [x, y, z], q_wxyz: [w, x, y, z]}");
    }
    SectionReader inner(entry->value, entry->path, entry->line, report_);
    const FieldSpec required{.unit = "m", .required = true, .text = "x, y, z"};
    const FieldSpec quaternion{.required = true, .text = "unit quaternion w, x, y, z"};
    const Entry* p_entry = inner.Take("p", required);
    const Entry* q_entry = inner.Take("q_wxyz", quaternion);
    std::optional<std::array<double, 3>> p;
    std::optional<std::array<double, 4>> q;
    if (p_entry != nullptr) p = inner.ReadDoubles<3>(*p_entry, required);
    if (q_entry != nullptr) q = inner.ReadDoubles<4>(*q_entry, quaternion);
    inner.Finish();
    if (!p || !q) return;
    const Eigen::Quaterniond rotation((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
    const double norm = rotation.norm();
    if (!(std::abs(norm - 1.0) <= kQuaternionNormTolerance)) {
      return report_->Add(q_entry->line, q_entry->path + ": norm is " + FormatDouble(norm) +
                                             ", must be 1 (+-0.001); order is w, x, y, z");
    }
    value = SE3(rotation, Eigen::Vector3d((*p)[0], (*p)[1], (*p)[2]));
  }

  template <typename S>
  void Section(const char* name, S& section, const FieldSpec& spec) {
    const Entry* entry = Take(name, spec);
    if (entry == nullptr) return;
    SectionReader inner(entry->value, entry->path, entry->line, report_);
    if (!inner.readable_) return;
    section.VisitFields(inner);
    inner.Finish();
  }

  // To be called after all fields were visited: what nobody asked for is a mistake.
  void Finish() {
    for (const Entry& entry : entries_) {
      if (entry.taken) continue;
      std::string advice = "no such key, remove it";
      int best = 3;  // more edits than two make another word
      for (const std::string& known : known_) {
        const int distance = EditDistance(entry.name, known);
        if (distance < best && 2 * distance <= static_cast<int>(entry.name.size())) {
          best = distance;
          advice = "no such key, did you mean `" + known + "`?";
        }
      }
      report_->Add(entry.line, entry.path + ": " + advice);
    }
  }

 private:
  struct Entry {
    std::string name;
    std::string path;
    int line = 0;
    YAML::Node value;
    bool taken = false;
  };

  void ReadEntry(const YAML::Node& key, const YAML::Node& value) {
    const int line = LineOf(key.Mark());
    if (!key.IsScalar()) {
      return report_->Add(line, (path_.empty() ? "file" : path_) + ": a key must be one word");
    }
    Entry entry{key.Scalar(), PathOf(key.Scalar()), line, value, false};
    const auto first = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& e) { return e.name == entry.name; });
    if (first != entries_.end()) {
      return report_->Add(line, entry.path + " = " + ValueText(value) +
                                    ": duplicate key, first in line " +
                                    std::to_string(first->line) + ", remove one");
    }
    report_->Remember(entry.path, line, value.IsScalar() ? ValueText(value) : "");
    entries_.push_back(std::move(entry));
  }

  std::string PathOf(const std::string& name) const {
    return path_.empty() ? name : path_ + "." + name;
  }

  // The entry of a key, or null when the file does not have it (an error if it is required).
  const Entry* Take(const char* name, const FieldSpec& spec) {
    known_.emplace_back(name);
    for (Entry& entry : entries_) {
      if (entry.name != name) continue;
      entry.taken = true;
      return &entry;
    }
    if (spec.required) {
      const std::string unit = *spec.unit == '\0' ? "" : std::string(" (") + spec.unit + ")";
      report_->Add(line_, PathOf(name) + ": missing, add it: " + spec.text + unit);
    }
    return nullptr;
  }

  std::optional<double> ReadDouble(const Entry& entry, const FieldSpec& spec) {
    const auto text = PlainText(entry.value);
    double value = 0;
    if (!text || !ParseNumber(*text, &value) || !std::isfinite(value)) {
      Bad(entry, "must be a finite number, write it without quotes");
      return std::nullopt;
    }
    if (value < spec.min || value > spec.max) {
      OutOfRange(entry, spec);
      return std::nullopt;
    }
    return value;
  }

  template <size_t N>
  std::optional<std::array<double, N>> ReadDoubles(const Entry& entry, const FieldSpec& spec) {
    const std::string rule = "must be a list of " + std::to_string(N) + " numbers";
    if (!entry.value.IsSequence()) {
      Bad(entry, rule);
      return std::nullopt;
    }
    if (entry.value.size() != N) {
      Bad(entry, rule + ", has " + std::to_string(entry.value.size()));
      return std::nullopt;
    }
    std::array<double, N> out{};
    bool good = true;
    for (size_t i = 0; i < N; ++i) {
      const YAML::Node element = entry.value[i];
      const std::string path = entry.path + "[" + std::to_string(i) + "]";
      const auto value = ReadDouble({"", path, LineOf(element.Mark()), element, true}, spec);
      good = good && value.has_value();
      if (value) out[i] = *value;
    }
    return good ? std::optional(out) : std::nullopt;
  }

  void Bad(const Entry& entry, const std::string& rule) {
    report_->Add(entry.line, entry.path + " = " + ValueText(entry.value) + ": " + rule);
  }
  void OutOfRange(const Entry& entry, const FieldSpec& spec) {
    const std::string unit = *spec.unit == '\0' ? "" : std::string(" ") + spec.unit;
    const std::string range = LegalRange(spec);
    Bad(entry, "out of range, must be " + (range.empty() ? "a 32-bit int" : range) + unit);
  }

  std::string path_;
  int line_;
  Report* report_;
  bool readable_ = true;
  std::vector<Entry> entries_;
  std::vector<std::string> known_;
};

Result<RobotConfig> ReadDocuments(const std::string& text, const std::string& name) {
  const std::vector<YAML::Node> documents = YAML::LoadAll(text);
  Report report(name);
  if (documents.empty() || (documents.size() == 1 && documents[0].IsNull())) {
    report.Add(1, "file is empty, start from a file in config/robots");
    return report.ToError();
  }
  if (documents.size() > 1) {
    report.Add(LineOf(documents[1].Mark()), "a second document starts here, one file is one robot");
    return report.ToError();
  }
  RobotConfig config;
  SectionReader root(documents[0], "", 1, &report);
  if (documents[0].IsMap()) {
    config.VisitFields(root);
    root.Finish();
  }
  // Rules between fields make sense only where every field by itself is right.
  std::vector<RuleViolation> violations = CheckRules(config);
  std::erase_if(violations, [&report](const RuleViolation& violation) {
    return report.HasMistakeIn(violation.key.substr(0, violation.key.find('.')));
  });
  for (const RuleViolation& violation : violations) report.AddRule(violation);
  if (!report.empty()) return report.ToError();
  return config;
}

}  // namespace

Result<RobotConfig> ParseRobotConfig(const std::string& text, const std::string& name) {
  try {
    return ReadDocuments(text, name);
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig, name + ":" + std::to_string(std::max(1, LineOf(e.mark))) +
                                            ": not valid YAML: " + e.msg};
  }
}

Result<RobotConfig> LoadRobotConfig(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return Error{ErrorCode::kNotFound, path + ": cannot open this configuration file: " +
                                           std::generic_category().message(errno)};
  }
  std::ostringstream text;
  if (file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
  if (file.bad() || text.fail()) {
    return Error{ErrorCode::kIo, path + ": cannot read this configuration file"};
  }
  return ParseRobotConfig(text.str(), path);
}

}  // namespace gw

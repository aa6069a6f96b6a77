#include "tools/lab/bench_suite/suite.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "tools/data/files/strict_yaml.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/slam/variant.h"

namespace gw::bench {
namespace {

using tools::StrictMap;
using tools::YamlReport;

bool IsFileName(const std::string& name) {
  return !name.empty() && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '-';
         });
}

std::vector<std::string> ReadTexts(StrictMap* map, const char* key, bool required) {
  std::vector<std::string> out;
  const YAML::Node node = map->Take(key, required);
  if (!node.IsDefined()) return out;
  bool good = node.IsSequence() && node.size() > 0;
  for (const auto& element : node) good = good && element.IsScalar();
  if (!good) {
    map->report()->Add(node, map->PathOf(key) + ": must be a list of texts");
    return out;
  }
  for (const auto& element : node) out.push_back(element.Scalar());
  return out;
}

void ReadSettings(StrictMap* map, std::vector<std::pair<std::string, std::string>>* out) {
  const YAML::Node node = map->Take("set");
  if (!node.IsDefined()) return;
  if (!node.IsMap()) {
    map->report()->Add(node, map->PathOf("set") + ": must be keys and values");
    return;
  }
  for (const auto& entry : node) {
    if (entry.first.IsScalar() && entry.second.IsScalar()) {
      out->emplace_back(entry.first.Scalar(), entry.second.Scalar());
    } else {
      map->report()->Add(entry.first, map->PathOf("set") + ": a value must be a text or a number");
    }
  }
}

void ReadAlignment(StrictMap* map, eval::Alignment* alignment) {
  map->Choice<eval::Alignment>("align", alignment,
                               {{"se3", eval::Alignment::kSe3},
                                {"yaw", eval::Alignment::kYaw},
                                {"none", eval::Alignment::kNone}});
}

// "{data}/..." and "{suite}/..." in the options of gw-sim and gw-import.
void ReplaceFolders(const std::filesystem::path& suite_folder, const std::filesystem::path& data,
                    std::string* option) {
  for (const auto& [name, folder] :
       {std::pair("{data}", data), std::pair("{suite}", suite_folder)}) {
    if (option->starts_with(name)) option->replace(0, std::string(name).size(), folder.string());
  }
}

void ReadInput(const YAML::Node& node, const std::string& path,
               const std::filesystem::path& suite_folder, const std::filesystem::path& data,
               eval::Alignment alignment, YamlReport* report, SuiteInput* out) {
  out->alignment = alignment;
  StrictMap map(node, path, report);
  map.Text("name", &out->name, true);
  if (!out->name.empty() && !IsFileName(out->name)) {
    report->Add(node, map.PathOf("name") + ": may hold letters, digits, '_', '.' and '-'");
  }
  std::string log, scenario, recording;
  map.Text("log", &log);
  map.Text("scenario", &scenario);
  map.Text("recording", &recording);
  map.Text("config", &out->config);
  map.Text("format", &out->format);
  out->options = ReadTexts(&map, "options", false);
  for (std::string& option : out->options) ReplaceFolders(suite_folder, data, &option);
  out->fault = ReadTexts(&map, "fault", false);
  ReadSettings(&map, &out->set);
  ReadAlignment(&map, &out->alignment);
  map.Finish();
  if (static_cast<int>(log.empty()) + static_cast<int>(scenario.empty()) +
          static_cast<int>(recording.empty()) !=
      2) {
    report->Add(node, path + ": needs exactly one of log, scenario and recording");
    return;
  }
  const auto needs = [&](const char* key, const std::string& value, bool wanted) {
    if (wanted == value.empty()) {
      report->Add(node, map.PathOf(key) + (wanted ? ": missing, add it" : ": has no use here"));
    }
  };
  needs("config", out->config, !log.empty());
  needs("format", out->format, !recording.empty());
  if (!log.empty()) {
    if (!out->options.empty()) report->Add(node, map.PathOf("options") + ": has no use here");
    out->path = (suite_folder / log).lexically_normal().string();
    out->config = (suite_folder / out->config).lexically_normal().string();
  } else if (!scenario.empty()) {
    out->source = Source::kScenario;
    out->path = (suite_folder / scenario).lexically_normal().string();
  } else {
    out->source = Source::kImport;
    out->path = (data / recording).lexically_normal().string();
  }
}

void ReadInputs(const YAML::Node& node, const std::filesystem::path& suite_folder,
                const std::filesystem::path& data, eval::Alignment alignment, YamlReport* report,
                std::vector<SuiteInput>* out) {
  if (!node.IsDefined()) return;
  if (!node.IsSequence() || node.size() == 0) {
    report->Add(node, "inputs: must be a list");
    return;
  }
  std::set<std::string> names;
  for (const auto& element : node) {
    const std::string path = "inputs[" + std::to_string(out->size()) + "]";
    ReadInput(element, path, suite_folder, data, alignment, report, &out->emplace_back());
    if (!names.insert(out->back().name).second) {
      report->Add(element, path + ".name: another input has this name");
    }
  }
}

void ReadSearch(const YAML::Node& node, YamlReport* report, CidSimsSearch* out) {
  if (!node.IsDefined()) return;
  StrictMap map(node, "find_cid_sims", report);
  out->wanted = true;
  out->low = ReadTexts(&map, "low", true);
  map.Finish();
}

void ReadLidarTruth(const YAML::Node& node, YamlReport* report, LidarTruth* out) {
  if (!node.IsDefined()) return;
  StrictMap map(node, "lidar_truth", report);
  map.Number("rate_hz", &out->rate_hz, 1, 1000, true);
  map.Number("metres", &out->metres, 0, 1, true);
  map.Number("degrees", &out->degrees, 0, 30, true);
  map.Finish();
}

void ReadMethods(const YAML::Node& node, const std::filesystem::path& suite_folder,
                 YamlReport* report, std::vector<OtherMethod>* out) {
  if (!node.IsDefined()) return;
  if (!node.IsMap()) {
    report->Add(node, "methods: must be names and paths");
    return;
  }
  for (const auto& entry : node) {
    OtherMethod& method = out->emplace_back();
    method.name = entry.first.Scalar();
    const std::string path = "methods." + method.name;
    if (entry.second.IsScalar()) {
      method.pattern = entry.second.Scalar();
    } else {
      StrictMap map(entry.second, path, report);
      map.Text("path", &method.pattern, true);
      map.Choice<bool>("frame", &method.of_body, {{"camera", false}, {"body", true}});
      map.Finish();
    }
    if (method.pattern.find("{sequence}") == std::string::npos) {
      report->Add(entry.first, path + ": needs a path with {sequence}");
    }
    method.pattern = (suite_folder / method.pattern).lexically_normal().string();
  }
}

Result<std::vector<PublishedRow>> ReadPublished(const std::string& path) {
  const auto text = tools::ReadTextFile(path);
  if (!text) return text.error();
  YamlReport report(path);
  std::vector<PublishedRow> out;
  try {
    for (const auto& element : YAML::Load(*text)) {
      StrictMap map(element, "[" + std::to_string(out.size()) + "]", &report);
      PublishedRow& row = out.emplace_back();
      map.Text("name", &row.name, true);
      map.Text("source", &row.source, true);
      std::string date;
      map.Text("date", &date, true);
      row.source += " (" + date + ")";
      double percent = -1, ape = -1;
      map.Number("completeness_percent", &percent, 0, 100);
      map.Number("ape_m", &ape, 0, 1000);
      if (percent >= 0) row.completeness = percent / 100;
      if (ape >= 0) row.ape_m = ape;
      map.Finish();
    }
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig, path + ": not valid YAML: " + e.what()};
  }
  if (!report.empty()) return Error{ErrorCode::kBadConfig, report.Text()};
  return out;
}

Suite Read(const YAML::Node& root, const std::filesystem::path& suite_folder,
           const std::filesystem::path& data, YamlReport* report, std::string* published) {
  Suite suite;
  StrictMap map(root, "", report);
  map.Text("name", &suite.name, true);
  std::string ignored;
  map.Text("description", &ignored);
  map.Text("published", published);
  map.Integer("runs", &suite.runs, 1, 100);
  ReadAlignment(&map, &suite.alignment);
  suite.variants = ReadTexts(&map, "variants", true);
  for (const std::string& variant : suite.variants) {
    FrontendConfig config;
    const auto known = tools::ApplyVariant(variant, &config);
    if (!known) report->Add(root["variants"], "variants: " + known.error().message);
  }
  if (std::set(suite.variants.begin(), suite.variants.end()).size() != suite.variants.size()) {
    report->Add(root["variants"], "variants: one stands there twice");
  }
  ReadSearch(map.Take("find_cid_sims"), report, &suite.cid_sims);
  ReadLidarTruth(map.Take("lidar_truth"), report, &suite.lidar_truth);
  ReadMethods(map.Take("methods"), suite_folder, report, &suite.methods);
  ReadInputs(map.Take("inputs", !suite.cid_sims.wanted), suite_folder, data, suite.alignment,
             report, &suite.inputs);
  map.Finish();
  return suite;
}

}  // namespace

Result<Suite> LoadSuite(const std::string& path, const std::string& data) {
  const auto text = tools::ReadTextFile(path);
  if (!text) return text.error();
  YamlReport report(path);
  try {
    namespace fs = std::filesystem;
    const fs::path data_folder = data.empty() ? fs::path() : fs::absolute(data);
    const fs::path suite_folder = fs::absolute(path).parent_path();
    std::string published;
    Suite suite = Read(YAML::Load(*text), suite_folder, data_folder, &report, &published);
    if (!report.empty()) return Error{ErrorCode::kBadConfig, report.Text()};
    if (published.empty()) return suite;
    auto rows = ReadPublished((suite_folder / published).lexically_normal().string());
    if (!rows) return rows.error();
    suite.published = *std::move(rows);
    return suite;
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig, path + ":" + std::to_string(std::max(0, e.mark.line) + 1) +
                                            ": not valid YAML: " + e.msg};
  }
}

}  // namespace gw::bench

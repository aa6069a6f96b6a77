#include "tools/lab/bench_suite/report.h"

#include <algorithm>
#include <set>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/eval/report.h"

namespace gw::bench {
namespace {

constexpr char kFailedColor[] = "#808080";
constexpr size_t kWidestTable = 12;  // columns of variants that fit a page

std::optional<double> ApeLive(const measure::Measures& m) {
  return m.ape_live_m;
}

std::string Fixed(const std::optional<double>& value, int decimals) {
  return value ? FormatFixed(*value, decimals) : "-";
}

// What this project is about, as against baselines, other systems and the literature.
bool IsOurs(const std::string& variant) {
  return variant == "da" || variant == "pe" || variant == "lba" || variant == "full";
}

// Grey: nothing that was computed from images here.
std::string ColorOf(const Ranked& r) {
  return r.variant == kDrAlone || r.total == 0 ? kFailedColor : "";
}

std::string Percent(double share) {
  return FormatFixed(100 * share, 0) + " %";
}

std::string Row(const std::vector<std::string>& cells) {
  std::string out = "|";
  for (const std::string& cell : cells) out += " " + cell + " |";
  return out + "\n";
}

std::string TableHead(const std::vector<std::string>& cells) {
  return Row(cells) + Row(std::vector<std::string>(cells.size(), "---"));
}

// "0.016 (0.015 - 0.018)", or why not.
std::string ApeCell(const Sequence& s) {
  const auto mean = s.Mean(ApeLive);
  std::string out = Fixed(mean, 3);
  if (mean && s.runs.size() > 1) {
    out += " (" + Fixed(s.Min(ApeLive), 3) + " - " + Fixed(s.Max(ApeLive), 3) + ")";
  }
  if (s.failed()) {
    out += " **failed**";
    const auto tracked = s.Mean([](const auto& m) { return m.tracked_share(); });
    if (tracked && *tracked < 1) out += ", tracked " + Percent(*tracked);
  }
  return out;
}

std::string NeesCell(const measure::NeesCount& nees) {
  if (nees.windows == 0) return "-";
  const auto windows = static_cast<double>(nees.windows);
  return Percent(nees.share_inside()) + " (" +
         Percent(static_cast<double>(nees.above + nees.undefined) / windows) + " too sure)";
}

std::vector<std::string> Unique(const std::vector<CellResult>& results,
                                std::string CellResult::*field) {
  std::vector<std::string> out;
  for (const CellResult& r : results) {
    if (std::find(out.begin(), out.end(), r.*field) == out.end()) out.push_back(r.*field);
  }
  return out;
}

const Sequence* Find(const std::vector<Sequence>& sequences, const std::string& input,
                     const std::string& variant) {
  for (const Sequence& s : sequences) {
    if (s.input == input && s.variant == variant) return &s;
  }
  return nullptr;
}

std::string Versions(const BenchReport& report) {
  std::set<std::string> versions;
  for (const CellResult& r : report.results) {
    if (!r.origin.version.empty()) {
      versions.insert(r.origin.version + " (binary " + r.slam_hash + ")");
    }
  }
  std::string out;
  for (const std::string& v : versions) out += (out.empty() ? "" : ", ") + v;
  return out;
}

std::string Seeds(const BenchReport& report) {
  return report.suite.runs == 1 ? "0" : "0 - " + std::to_string(report.suite.runs - 1);
}

// Inputs that are aligned in another way than the suite.
std::string Exceptions(const Suite& suite) {
  std::string out;
  for (const SuiteInput& input : suite.inputs) {
    if (input.alignment == suite.alignment) continue;
    out += (out.empty() ? " (" : ", ") + input.name + " " + eval::AlignmentName(input.alignment);
  }
  return out.empty() ? "" : out + ")";
}

std::string TruthNote(const LidarTruth& lidar) {
  if (lidar.rate_hz <= 0) return "";
  return "; ground truth as of a laser scanner: " + FormatDouble(lidar.rate_hz) + " Hz, noise " +
         FormatDouble(lidar.metres) + " m and " + FormatDouble(lidar.degrees) +
         " deg per axis, smoothed";
}

// "name: a, b," and so on, in lines of bounded length.
void AppendWrapped(const std::string& name, const std::vector<std::string>& items,
                   std::vector<std::string>* lines) {
  constexpr size_t kWidth = 120;
  std::string line = name;
  for (size_t i = 0; i < items.size(); ++i) {
    const std::string item = items[i] + (i + 1 < items.size() ? ", " : "");
    if (line.size() + item.size() > kWidth) {
      lines->push_back(line);
      line.clear();
    }
    line += item;
  }
  lines->push_back(line);
}

std::vector<std::string> PlotFooter(const BenchReport& report) {
  std::vector<std::string> out = {"suite " + report.suite.name + ", gw-slam " + Versions(report) +
                                  ", seeds " + Seeds(report) + ", alignment " +
                                  eval::AlignmentName(report.suite.alignment)};
  std::vector<std::string> configs;
  for (const CellResult& r : report.results) {
    const std::string config = r.variant + " " + r.origin.config_hash;
    if (r.origin.config_hash.empty()) continue;
    if (std::find(configs.begin(), configs.end(), config) == configs.end()) {
      configs.push_back(config);
    }
  }
  AppendWrapped("logs: ", Unique(report.results, &CellResult::log), &out);
  AppendWrapped("configuration hashes: ", configs, &out);
  return out;
}

std::string RankingTable(const BenchReport& report, const std::vector<Sequence>& sequences) {
  std::string out = TableHead({"variant", "completeness", "mean APE RMSE of the finished, m"});
  for (const Ranked& r : Rank(sequences, report.suite.published)) {
    std::string completeness = std::to_string(r.finished) + " / " + std::to_string(r.total);
    if (r.total == 0) completeness = r.completeness ? Percent(*r.completeness) : "-";
    out += Row({r.variant, completeness, Fixed(r.mean_ape_m, r.total == 0 ? 2 : 4)});
  }
  std::set<std::string> sources;
  for (const PublishedRow& row : report.suite.published) sources.insert(row.source);
  if (sources.empty()) return out;
  out += "\n\\* published, on the recordings of the data set, not run here:\n\n";
  for (const std::string& source : sources) {
    std::string names;
    for (const PublishedRow& row : report.suite.published) {
      if (row.source == source) names += (names.empty() ? "" : ", ") + row.name;
    }
    out += "* " + source + ": " + names + "\n";
  }
  return out;
}

std::optional<double> DrAlone(const std::vector<Sequence>& sequences, const std::string& input) {
  for (const Sequence& s : sequences) {
    if (s.input != input) continue;
    if (const auto dr = s.Mean([](const auto& m) { return m.ape_dr_m; })) return dr;
  }
  return std::nullopt;
}

// The shorter list is across, so that a suite of fifty variants can be read.
std::string InputTable(const BenchReport& report, const std::vector<Sequence>& sequences) {
  const auto inputs = Unique(report.results, &CellResult::input);
  const auto variants = Unique(report.results, &CellResult::variant);
  const auto cell = [&](const std::string& input, const std::string& variant) {
    const Sequence* const s = Find(sequences, input, variant);
    return s == nullptr ? std::string("-") : ApeCell(*s);
  };
  std::vector<std::vector<std::string>> rows = {{"input", kDrAlone}};
  rows[0].insert(rows[0].end(), variants.begin(), variants.end());
  for (const std::string& input : inputs) {
    rows.push_back({input, Fixed(DrAlone(sequences, input), 3)});
    for (const std::string& variant : variants) rows.back().push_back(cell(input, variant));
  }
  if (variants.size() > inputs.size() && variants.size() > kWidestTable) {
    std::vector<std::vector<std::string>> turned(rows[0].size());
    for (const auto& row : rows) {
      for (size_t i = 0; i < row.size(); ++i) turned[i].push_back(row[i]);
    }
    turned[0][0] = "variant";
    rows = std::move(turned);
  }
  std::string out = TableHead(rows[0]);
  for (size_t i = 1; i < rows.size(); ++i) out += Row(rows[i]);
  return out;
}

std::string DetailTable(const std::vector<Sequence>& sequences) {
  std::string out = TableHead({"input", "variant", "images", "lost", "blind", "APE live",
                               "APE final", "RPE 1 s, m", "RPE 1 s, deg", "jump, m",
                               "recovery jump, m", "NEES healthy", "NEES blind"});
  using M = measure::Measures;
  for (const Sequence& s : sequences) {
    const auto mean = [&](auto field, int decimals) {
      return Fixed(s.Mean([&](const M& m) { return std::optional<double>(m.*field); }), decimals);
    };
    out += Row({s.input, s.variant, mean(&M::images, 0), mean(&M::lost, 0), mean(&M::blind, 0),
                mean(&M::ape_live_m, 4), mean(&M::ape_final_m, 4), mean(&M::rpe_m, 4),
                mean(&M::rpe_deg, 3),
                Fixed(s.Max([](const M& m) { return std::optional(m.jumps.worst_m); }), 3),
                Fixed(s.Max([](const M& m) { return std::optional(m.jumps.worst_recovery_m); }), 3),
                NeesCell(s.Sum(&measure::Consistency::healthy)),
                NeesCell(s.Sum(&measure::Consistency::blind))});
  }
  return out;
}

std::string OriginTable(const BenchReport& report) {
  std::string out = TableHead(
      {"input", "log", "hash of the log", "dead reckoning", "configuration hash by variant"});
  for (const std::string& input : Unique(report.results, &CellResult::input)) {
    std::string log, hash, configs;
    bool synthetic = false;
    std::set<std::string> seen;
    for (const CellResult& r : report.results) {
      if (r.input != input) continue;
      log = r.log;
      hash = r.log_hash;
      synthetic |= r.origin.dr_synthetic;
      if (r.origin.config_hash.empty() || !seen.insert(r.variant).second) continue;
      configs += (configs.empty() ? "" : ", ") + r.variant + " " + r.origin.config_hash;
    }
    out += Row({input, log, hash, synthetic ? "**synthetic**" : "from sensors", configs});
  }
  return out;
}

std::string Failures(const BenchReport& report) {
  std::string out;
  for (const CellResult& r : report.results) {
    if (r.failure.empty()) continue;
    out += "* " + r.input + ", " + r.variant + ", seed " + std::to_string(r.seed) + ": " +
           r.failure + "\n";
  }
  return out.empty() ? "" : "\n## Runs without a result\n\n" + out;
}

}  // namespace

std::string RenderMarkdown(const BenchReport& report) {
  const std::vector<Sequence> sequences = Sequences(report.results);
  return "# Benchmark " + report.suite.name + "\n\ngw-slam " + Versions(report) + ", gw-bench " +
         Version() + "; seeds " + Seeds(report) + " (seed N starts 3 N images later); alignment " +
         eval::AlignmentName(report.suite.alignment) + Exceptions(report.suite) +
         TruthNote(report.suite.lidar_truth) +
         ".\n\n## Ranking\n\n"
         "Failed: any run with an APE RMSE above 10 m or less than half of the images "
         "tracked.\n\n" +
         RankingTable(report, sequences) +
         "\n## APE RMSE by input, m\n\n"
         "Of all poses as they were published, lost ones included: mean (min - max) of the "
         "runs.\n\n" +
         InputTable(report, sequences) +
         "\n## All numbers\n\n"
         "Means of the runs; jumps: the worst. lost: images for which the system claims no pose; "
         "blind: on dead\nreckoning alone. jump: motion between two images beyond that of dead "
         "reckoning. NEES: share of 1 s windows inside\nthe 95 % band.\n\n" +
         DetailTable(sequences) + "\n## Where the numbers come from\n\n" + OriginTable(report) +
         Failures(report);
}

std::string RenderCsv(const BenchReport& report) {
  std::string out =
      "input,variant,seed,log,log_hash,config_hash,version,dr_synthetic,failed,images,lost,blind,"
      "ape_live_m,ape_final_m,ape_dr_m,rpe_m,rpe_deg,jump_m,recovery_jump_m,"
      "nees_healthy_windows,nees_healthy_inside,nees_healthy_above,nees_healthy_undefined,"
      "nees_blind_windows,nees_blind_inside,nees_blind_above,nees_blind_undefined\n";
  for (const CellResult& r : report.results) {
    out += r.input + "," + r.variant + "," + std::to_string(r.seed) + "," + r.log + "," +
           r.log_hash + "," + r.origin.config_hash + "," + r.origin.version + "," +
           (r.origin.dr_synthetic ? "1" : "0") + "," + (RunFailed(r) ? "1" : "0");
    const measure::Measures m = r.measures.value_or(measure::Measures{});
    for (const int64_t n : {m.images, m.lost, m.blind}) out += "," + std::to_string(n);
    const auto number = [&out](const std::optional<double>& v) {
      out += "," + (v ? FormatDouble(*v) : "");
    };
    for (const auto& v : {m.ape_live_m, m.ape_final_m, m.ape_dr_m, m.rpe_m, m.rpe_deg}) number(v);
    number(m.jumps.worst_m);
    number(m.jumps.worst_recovery_m);
    for (const measure::NeesCount& n : {m.consistency.healthy, m.consistency.blind}) {
      for (const int64_t v : {n.windows, n.inside, n.above, n.undefined}) {
        out += "," + std::to_string(v);
      }
    }
    out += "\n";
  }
  return out;
}

std::string RenderTimingCsv(const BenchReport& report) {
  std::string out = "input,variant,seed,ms_median,ms_p99\n";
  for (const CellResult& r : report.results) {
    if (!r.measures || !r.measures->ms_median || !r.measures->ms_p99) continue;
    out += r.input + "," + r.variant + "," + std::to_string(r.seed) + "," +
           FormatFixed(*r.measures->ms_median, 3) + "," + FormatFixed(*r.measures->ms_p99, 3) +
           "\n";
  }
  return out;
}

plot::Drawing DrawRanking(const BenchReport& report) {
  plot::BarPanel completeness, ape;
  completeness.title = "completeness";
  completeness.x_label = "% of the inputs (hatched: not all)";
  completeness.x_max = 100;
  ape.title = "accuracy";
  ape.x_label = "mean APE RMSE over the finished inputs, m";
  for (const Ranked& r : Rank(Sequences(report.results), report.suite.published)) {
    plot::Bar bar{r.variant, std::nullopt, "-", !r.complete(), IsOurs(r.variant), ColorOf(r)};
    ape.bars.push_back(bar);
    ape.bars.back().value = r.mean_ape_m;
    ape.bars.back().note = Fixed(r.mean_ape_m, r.total == 0 ? 2 : 3);
    if (r.completeness) {
      bar.value = 100 * *r.completeness;
      bar.note = Percent(*r.completeness);
    }
    completeness.bars.push_back(bar);
  }
  plot::BarFigure figure;
  figure.title = report.suite.name + ": completeness and accuracy";
  figure.columns = 2;
  figure.panel_width = 480;
  figure.panels = {completeness, ape};
  figure.footer = PlotFooter(report);
  if (!report.suite.published.empty()) {
    figure.footer.emplace_back("* published, on the recordings of the data set, not run here");
  }
  return plot::Draw(figure);
}

plot::Drawing DrawInputs(const BenchReport& report) {
  const std::vector<Sequence> sequences = Sequences(report.results);
  plot::BarFigure figure;
  figure.title = report.suite.name + ": every input";
  figure.columns = 2;
  figure.panel_width = 480;
  for (const std::string& input : Unique(report.results, &CellResult::input)) {
    plot::BarPanel panel;
    panel.title = input;
    panel.x_label = "APE RMSE, m (hatched: failed)";
    double finished_max = 0;
    for (const Sequence& s : sequences) {
      if (s.input != input) continue;
      const auto ape = s.Mean(ApeLive);
      if (!s.failed()) finished_max = std::max(finished_max, ape.value_or(0));
      const std::string failed = s.failed() ? " failed" : "";
      panel.bars.push_back(
          {s.variant, ape, Fixed(ape, 3) + failed, s.failed(), IsOurs(s.variant), ""});
      if (!panel.marker) panel.marker = s.Mean([](const auto& m) { return m.ape_dr_m; });
    }
    panel.marker_label = kDrAlone;
    // Failed runs would squeeze the others against the axis.
    const double shown = std::max(finished_max, panel.marker.value_or(0));
    if (shown > 0) panel.x_max = 1.15 * shown;
    figure.panels.push_back(std::move(panel));
  }
  figure.footer = PlotFooter(report);
  return plot::Draw(figure);
}

}  // namespace gw::bench

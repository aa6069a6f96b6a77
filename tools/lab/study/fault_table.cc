#include "tools/lab/study/fault_table.h"

#include <algorithm>
#include <utility>

#include "common/core/format.h"
#include "tools/lab/plot/drawing.h"

namespace gw::study {
namespace {

// The bars of docs/results.md, section "Fault matrices".
constexpr double kOverVision = 1.1;   // faults of DR, vision healthy
constexpr double kOverWheels = 1.05;  // faults of DR, vision not healthy
constexpr double kOverDr = 1.25;      // faults of vision
constexpr double kOverSound = 1.1;
constexpr double kNamedWithin = 10;  // s
constexpr double kTooSureFor = 2;    // s

std::optional<double> Times(double factor, const std::optional<double>& value) {
  if (!value) return std::nullopt;
  return factor * *value;
}

std::optional<double> BarOf(FaultMatrix matrix, bool vision_healthy, const FaultRow& row) {
  if (matrix == FaultMatrix::kVision) {
    return std::max(Times(kOverDr, row.dr_m), Times(kOverSound, row.sound_full_m));
  }
  if (vision_healthy) return Times(kOverVision, row.none_m);
  return Times(kOverWheels, row.wheels_m ? row.wheels_m : row.dr_m);
}

bool Names(const Saying& saying, Accused guilty) {
  if (!saying.in_health) return false;
  return saying.accused == guilty || (saying.accused == Accused::kDr && guilty != Accused::kVision);
}

// Seconds until one start names the guilty one.
std::optional<double> NamedAfter(Accused guilty, const std::vector<Saying>& sayings) {
  for (const Saying& s : sayings) {
    if (Names(s, guilty)) return s.after_s;
  }
  return std::nullopt;
}

std::string Number(const std::optional<double>& value, int decimals) {
  return value ? FormatFixed(*value, decimals) : "-";
}

std::string SayingsText(const FaultOutcome& outcome) {
  std::string out;
  for (const Saying& s : outcome.sayings) {
    out += (out.empty() ? "" : ", ") + s.name + " (" + FormatFixed(s.after_s, 1) + " s; " +
           std::to_string(s.count) + (s.in_health ? "" : "; *") + ")";
  }
  if (!outcome.explanation.empty()) out += "; \"" + outcome.explanation + "\"";
  return out.empty() ? "nothing" : out;
}

std::string MissesText(const FaultVerdict& verdict) {
  std::string out;
  for (const std::string& miss : verdict.misses) out += (out.empty() ? "" : ", ") + miss;
  return out.empty() ? "met" : "**" + out + "**";
}

const char* BarText(FaultMatrix matrix, bool vision_healthy) {
  if (matrix == FaultMatrix::kVision) {
    return "Bar: the larger of 1.25 x DR alone and 1.1 x `full` without the fault; never tracking "
           "for more than 2 s with an error over 5 sigma; named.";
  }
  return vision_healthy
             ? "Vision alone keeps its pose on this log. Bar: 1.1 x `none`; a pose for every "
               "image; "
               "named within 10 s."
             : "Vision alone loses its pose on this log. Bar: 1.05 x the faulty wheels' own sum; a "
               "pose for every image; named within 10 s.";
}

std::string Csv(FaultMatrix matrix, bool vision_healthy, const std::vector<FaultRow>& rows) {
  std::string out =
      "fault,full_m,none_m,dr_m,wheels_m,full_without_fault_m,bar_m,ratio,named_after_s,"
      "images_without_pose,too_sure_s,verdict,said\n";
  for (const FaultRow& row : rows) {
    const FaultVerdict v = Judge(matrix, vision_healthy, row);
    out += row.name;
    for (const auto& value :
         {v.full_m, row.none_m, row.dr_m, row.wheels_m, row.sound_full_m, v.bar_m, v.ratio}) {
      out += "," + (value ? FormatDouble(*value) : "");
    }
    std::string misses, said;
    for (const std::string& miss : v.misses) misses += (misses.empty() ? "" : "; ") + miss;
    for (const Saying& s : row.full.front().sayings) {
      said.append(said.empty() ? "" : "; ").append(s.name).append(" ");
      said.append(FormatFixed(s.after_s, 2));
    }
    for (const std::string& cell :
         {v.named_after_s ? FormatFixed(*v.named_after_s, 2) : "", std::to_string(v.without_pose),
          FormatFixed(v.too_sure_s, 2), misses, said}) {
      out.append(",").append(cell);
    }
    out.append("\n");
  }
  return out;
}

plot::Drawing Bars(FaultMatrix matrix, bool vision_healthy, const std::string& origin,
                   const std::vector<FaultRow>& rows) {
  plot::BarPanel panel;
  panel.title = "error of the pose over what it may be";
  panel.x_label = "APE of `full` / bar";
  panel.x_max = 3;
  panel.marker = 1;
  panel.marker_label = "bar";
  for (const FaultRow& row : rows) {
    const FaultVerdict v = Judge(matrix, vision_healthy, row);
    plot::Bar bar;
    bar.label = row.name;
    bar.value = v.ratio;
    bar.note = Number(v.full_m, 3) + " m";
    for (const std::string& miss : v.misses) bar.note += ", " + miss;
    bar.hatched = v.misses.empty();
    panel.bars.push_back(std::move(bar));
  }
  plot::BarFigure figure;
  figure.title = matrix == FaultMatrix::kDr ? "Faults of dead reckoning" : "Faults of vision";
  figure.panel_width = 960;
  figure.panels = {panel};
  figure.footer = {origin, "hatched: every bar met"};
  return plot::Draw(figure);
}

}  // namespace

std::vector<Saying> SayingsOf(const Findings& findings, const Findings& without_fault,
                              Utime visible) {
  std::vector<Saying> out;
  for (const auto& [name, finding] : findings) {
    if (without_fault.contains(name)) continue;
    Saying saying;
    saying.name = name;
    saying.after_s = std::max(0.0, (finding.first - visible).seconds());
    saying.count = finding.count;
    saying.accused = finding.accused;
    saying.in_health = finding.in_health;
    out.push_back(std::move(saying));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Saying& a, const Saying& b) { return a.after_s < b.after_s; });
  return out;
}

FaultVerdict Judge(FaultMatrix matrix, bool vision_healthy, const FaultRow& row) {
  FaultVerdict out;
  double sum = 0;
  bool determined = true, named = true;
  double slowest = 0;
  for (const FaultOutcome& outcome : row.full) {
    determined &= outcome.numbers.ape_m.has_value();
    sum += outcome.numbers.ape_m.value_or(0);
    out.without_pose = std::max(out.without_pose, outcome.numbers.without_pose);
    out.too_sure_s = std::max(out.too_sure_s, outcome.numbers.too_sure_s);
    const auto after_s = NamedAfter(row.guilty, outcome.sayings);
    named &= after_s.has_value();
    slowest = std::max(slowest, after_s.value_or(0));
  }
  if (determined) out.full_m = sum / static_cast<double>(row.full.size());
  if (named) out.named_after_s = slowest;
  out.bar_m = BarOf(matrix, vision_healthy, row);
  if (out.full_m && out.bar_m) out.ratio = *out.full_m / *out.bar_m;

  if (!out.ratio || *out.ratio > 1) out.misses.push_back("error");
  if (matrix == FaultMatrix::kDr && out.without_pose > 0) out.misses.push_back("no pose");
  if (matrix == FaultMatrix::kVision && out.too_sure_s > kTooSureFor) {
    out.misses.push_back("too sure");
  }
  const double limit = matrix == FaultMatrix::kDr ? kNamedWithin : INFINITY;
  if (!out.named_after_s || *out.named_after_s > limit) out.misses.push_back("not named");
  return out;
}

StudyFiles RenderFaults(FaultMatrix matrix, bool vision_healthy, const std::string& origin,
                        double sound_too_sure_s, const std::vector<FaultRow>& rows) {
  StudyFiles files;
  files.markdown =
      std::string(matrix == FaultMatrix::kDr ? "# Faults of dead reckoning"
                                             : "# Faults of vision") +
      "\n\n" + origin + ". APE RMSE in m, live poses. " + BarText(matrix, vision_healthy) +
      " Said: what the run without fault does not say (s after the fault could be seen; how "
      "often; *: only in FRAME_POSE or DR, not in HEALTH). Too sure: longest span of tracking with "
      "an error over 5 sigma, s; without a fault " +
      FormatFixed(sound_too_sure_s, 1) +
      ".\n\n| fault | `full` | `none` | DR alone | wheels alone | `full` without the fault | "
      "`full` "
      "/ bar | said | images without pose | too sure | bar |\n| --- | --- | --- | --- | --- | --- "
      "| "
      "--- | --- | --- | --- | --- |\n";
  for (const FaultRow& row : rows) {
    const FaultVerdict v = Judge(matrix, vision_healthy, row);
    files.markdown += "| " + row.name + " | " + Number(v.full_m, 4) + " | " +
                      Number(row.none_m, 4) + " | " + Number(row.dr_m, 3) + " | " +
                      Number(row.wheels_m, 3) + " | " + Number(row.sound_full_m, 4) + " | " +
                      Number(v.ratio, 2) + " | " + SayingsText(row.full.front()) + " | " +
                      std::to_string(v.without_pose) + " | " + FormatFixed(v.too_sure_s, 1) +
                      " | " + MissesText(v) + " |\n";
  }
  files.csv = Csv(matrix, vision_healthy, rows);
  files.drawing = Bars(matrix, vision_healthy, origin, rows);
  return files;
}

}  // namespace gw::study

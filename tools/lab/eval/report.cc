#include "tools/lab/eval/report.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/core/format.h"
#include "tools/data/files/json.h"
#include "tools/lab/plot/svg.h"

namespace gw::eval {
namespace {

// --- JSON ---

using tools::Json;

Json StatsJson(const Stats& stats) {
  if (stats.count == 0) return nullptr;
  return {{"count", stats.count},
          {"rmse", stats.rmse},
          {"mean", stats.mean},
          {"median", stats.median},
          {"max", stats.max}};
}

// --- table ---

std::string Padded(const std::string& text, size_t width, bool to_the_right) {
  const std::string pad(text.size() < width ? width - text.size() : 0, ' ');
  return to_the_right ? pad + text : text + pad;
}

std::string Row(const std::string& name, const Stats& stats) {
  std::string out = Padded(name, 26, false);
  for (const double v : {stats.rmse, stats.mean, stats.median, stats.max}) {
    out += Padded(stats.count == 0 ? "-" : FormatFixed(v, 4), 11, true);
  }
  return out + Padded(std::to_string(stats.count), 9, true) + "\n";
}

std::string Fact(const std::string& name, const std::string& text) {
  return Padded(name, 26, false) + "  " + text + "\n";
}

std::string Percent(double share) {
  return FormatFixed(100 * share, 1) + " %";
}

std::string Optional(const std::optional<double>& value, int decimals, const std::string& unit) {
  return value ? FormatFixed(*value, decimals) + unit : "-";
}

// --- plot ---

constexpr double kPenUp = std::numeric_limits<double>::quiet_NaN();
constexpr char kReferenceColor[] = "#808080";
constexpr char kEstimateColor[] = "#0072b2";
constexpr char kKeyframeColor[] = "#d55e00";

// The second axis of a map.
enum class Up { kY, kZ };

double Coordinate(const SE3& T, Up up) {
  return up == Up::kY ? T.translation().y() : T.translation().z();
}

plot::Series Path(const Trajectory& poses, Up up, const char* label, const char* color) {
  plot::Series series;
  series.label = label;
  series.color = color;
  const DurationUs pause = LongestPause(poses);
  for (size_t i = 0; i < poses.size(); ++i) {
    if (i > 0 && poses[i].utime - poses[i - 1].utime > pause) {
      series.x.push_back(kPenUp);
      series.y.push_back(kPenUp);
    }
    series.x.push_back(poses[i].T.translation().x());
    series.y.push_back(Coordinate(poses[i].T, up));
  }
  return series;
}

plot::Panel MapPanel(const EvalReport& report, const Trajectory& ref, const Trajectory& aligned,
                     Up up) {
  plot::Panel panel;
  panel.title = up == Up::kY ? "top view" : "side view";
  panel.x_label = "x (m)";
  panel.y_label = up == Up::kY ? "y (m)" : "z (m)";
  panel.equal_aspect = up == Up::kY;  // from the side a floor would be a line
  panel.series = {Path(ref, up, "reference", kReferenceColor),
                  Path(aligned, up, "estimate", kEstimateColor)};
  if (report.keyframes) {
    plot::Series keyframes;
    keyframes.label = "keyframes";
    keyframes.style = plot::Style::kPoints;
    keyframes.color = kKeyframeColor;
    for (const PosePair& pair : report.keyframes->pairs) {
      keyframes.x.push_back(pair.T_est.translation().x());
      keyframes.y.push_back(Coordinate(pair.T_est, up));
    }
    panel.series.push_back(std::move(keyframes));
  }
  return panel;
}

plot::Panel ErrorPanel(const EvalReport& report, const Trajectory& ref, const Trajectory& est,
                       const std::vector<double>& errors, const char* title, const char* unit) {
  plot::Panel panel;
  panel.title = title;
  panel.x_label = "time since the reference's begin (s)";
  panel.y_label = unit;
  const std::vector<PosePair>& pairs = report.frames.pairs;
  const DurationUs pause = LongestPause(est);
  plot::Series series;
  series.color = kEstimateColor;
  for (size_t i = 0; i < errors.size(); ++i) {
    if (i > 0 && pairs[i].utime - pairs[i - 1].utime > pause) {
      series.x.push_back(kPenUp);
      series.y.push_back(kPenUp);
    }
    series.x.push_back((pairs[i].utime - ref.front().utime).seconds());
    series.y.push_back(errors[i]);
  }
  panel.series.push_back(std::move(series));
  for (const auto& [begin, end] : Gaps(ref, est)) {
    panel.spans.push_back({begin, end, "no estimate"});
  }
  return panel;
}

}  // namespace

const char* AlignmentName(Alignment alignment) {
  switch (alignment) {
    case Alignment::kSe3:
      return "se3";
    case Alignment::kYaw:
      return "yaw";
    case Alignment::kNone:
      return "none";
  }
  return "";
}

std::optional<double> EvalReport::FrameToKeyframeRatio() const {
  if (!keyframes || !(keyframes->ape_translation_m.rmse > 0)) return std::nullopt;
  return frames.ape_translation_m.rmse / keyframes->ape_translation_m.rmse;
}

std::string RenderTable(const EvalReport& report) {
  const Evaluation& e = report.frames;
  const Drift& drift = e.drift;
  const std::string delta = FormatDouble(report.options.rpe_delta.seconds()) + " s";
  std::string out =
      Fact("reference", report.ref_name + " (" + std::to_string(e.num_ref) + " poses)") +
      Fact("estimate", report.est_name + " (" + std::to_string(e.num_est) + " poses, " +
                           std::to_string(e.pairs.size()) + " with reference)") +
      Fact("alignment", AlignmentName(report.options.alignment)) + "\n";
  out += Padded("", 26, false);
  for (const char* column : {"rmse", "mean", "median", "max"}) out += Padded(column, 11, true);
  out += Padded("count", 9, true) + "\n";
  out += Row("APE translation (m)", e.ape_translation_m);
  out += Row("APE rotation (deg)", e.ape_rotation_deg);
  out += Row("RPE " + delta + " translation (m)", e.rpe_translation_m);
  out += Row("RPE " + delta + " rotation (deg)", e.rpe_rotation_deg);
  if (report.keyframes) out += Row("keyframe APE (m)", report.keyframes->ape_translation_m);
  out += "\n" + Fact("path length", FormatFixed(drift.path_length_m, 3) + " m");
  out += Fact("final error", FormatFixed(drift.final_error_m, 4) + " m, " +
                                 FormatFixed(drift.final_error_deg, 3) + " deg, " +
                                 Optional(drift.final_percent, 3, " % of the path"));
  out += Fact("drift over segments", Optional(drift.segment_percent, 3, " %") + ", " +
                                         Optional(drift.segment_deg_per_m, 4, " deg/m") + " (" +
                                         std::to_string(drift.segments) + " segments)");
  out += Fact("completeness", Percent(e.completeness) + " of the reference's time");
  if (report.coverage) {
    out += Fact("coverage",
                Percent(*report.coverage) + " of " + std::to_string(*report.images) + " images");
  }
  if (report.keyframes) {
    out += Fact("R(F/KF)", Optional(report.FrameToKeyframeRatio(), 3, ""));
  }
  return out;
}

std::string RenderJson(const EvalReport& report) {
  const Evaluation& e = report.frames;
  const Eigen::Vector3d& p = e.T_RefEst.translation();
  const Eigen::Quaterniond& q = e.T_RefEst.rotation();
  const Drift& drift = e.drift;
  const Stats keyframes = report.keyframes ? report.keyframes->ape_translation_m : Stats{};
  const Json transform = {{"p", {p.x(), p.y(), p.z()}}, {"q_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
  const Json ape = {{"translation_m", StatsJson(e.ape_translation_m)},
                    {"rotation_deg", StatsJson(e.ape_rotation_deg)}};
  const Json rpe = {{"delta_s", report.options.rpe_delta.seconds()},
                    {"translation_m", StatsJson(e.rpe_translation_m)},
                    {"rotation_deg", StatsJson(e.rpe_rotation_deg)}};
  const Json drifts = {{"path_length_m", drift.path_length_m},
                       {"final_error_m", drift.final_error_m},
                       {"final_error_deg", drift.final_error_deg},
                       {"final_percent", tools::ValueOrNull(drift.final_percent)},
                       {"segment_lengths_m", report.options.segment_lengths_m},
                       {"segments", drift.segments},
                       {"segment_percent", tools::ValueOrNull(drift.segment_percent)},
                       {"segment_deg_per_m", tools::ValueOrNull(drift.segment_deg_per_m)}};
  return tools::JsonDocument(
      {{"reference", report.ref_name},
       {"estimate", report.est_name},
       {"alignment", AlignmentName(report.options.alignment)},
       {"max_gap_s", report.options.max_gap.seconds()},
       {"max_diff_s", report.options.max_diff.seconds()},
       {"reference_poses", e.num_ref},
       {"estimate_poses", e.num_est},
       {"pairs", e.pairs.size()},
       {"T_RefEst", transform},
       {"ape", ape},
       {"rpe", rpe},
       {"drift", drifts},
       {"completeness", e.completeness},
       {"images", tools::ValueOrNull(report.images)},
       {"coverage", tools::ValueOrNull(report.coverage)},
       {"keyframe_ape_translation_m", StatsJson(keyframes)},
       {"frame_to_keyframe_ratio", tools::ValueOrNull(report.FrameToKeyframeRatio())}});
}

std::string RenderPlot(const EvalReport& report, const Trajectory& ref, const Trajectory& est) {
  Trajectory aligned = est;
  for (TimedPose& pose : aligned) pose.T = report.frames.T_RefEst * pose.T;
  plot::Figure figure;
  figure.title = report.est_name + ": APE RMSE " +
                 FormatFixed(report.frames.ape_translation_m.rmse, 4) + " m, alignment " +
                 AlignmentName(report.options.alignment);
  figure.columns = 2;
  figure.panels = {
      MapPanel(report, ref, aligned, Up::kY), MapPanel(report, ref, aligned, Up::kZ),
      ErrorPanel(report, ref, est, report.frames.ape_m, "absolute position error", "m"),
      ErrorPanel(report, ref, est, report.frames.ape_deg, "absolute rotation error", "deg")};
  return plot::RenderSvg(figure);
}

}  // namespace gw::eval

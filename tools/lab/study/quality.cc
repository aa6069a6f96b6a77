#include "tools/lab/study/quality.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/eval/evaluate.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

constexpr char kVariant[] = "da";
constexpr int kDetectedWidth = 100;  // up to the 800 features that an image may have
constexpr int kDetectedBins = 9;
constexpr int kTrackedWidth = 20;
constexpr int kTrackedBins = 13;

struct Axis {
  const char* name;
  int QualitySample::*count;
  int width, bins;
};
constexpr Axis kAxes[] = {
    {"N_det", &QualitySample::num_detected, kDetectedWidth, kDetectedBins},
    {"N_trk", &QualitySample::num_tracked, kTrackedWidth, kTrackedBins},
};

class QualityStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("logs", logs_, "LCM event logs with ground truth")->Required();
    app.AddOption("--config", configs_, "robot YAML, once or once per log")->Required();
  }

  Result<StudyFiles> Run() override {
    if (configs_.size() != 1 && configs_.size() != logs_.size()) {
      return Error{ErrorCode::kInvalidArgument, "--config: give it once, or once per log"};
    }
    std::vector<QualitySample> samples;
    std::vector<std::string> origin = {std::string("variant ") + kVariant + ", seed 0, gw-study " +
                                       Version()};
    for (size_t i = 0; i < logs_.size(); ++i) {
      auto experiment = LoadExperiment(logs_[i], configs_[configs_.size() == 1 ? 0 : i]);
      if (!experiment) return experiment.error();
      const auto run = study::Run(&*experiment, kVariant, {});
      if (!run) return run.error();
      const auto of_log = QualitySamples(*run, experiment->truth);
      if (!of_log) {
        return Error{of_log.error().code, logs_[i] + ": " + of_log.error().message};
      }
      samples.insert(samples.end(), of_log->begin(), of_log->end());
      origin.push_back(Describe(*experiment) + ", configuration " +
                       ConfigHashText(*ConfigFor(*experiment, kVariant)));
      std::fprintf(stderr, "gw-study: %s: %zu images\n", experiment->name.c_str(), of_log->size());
    }
    return Render(samples, origin);
  }

 private:
  static StudyFiles Render(const std::vector<QualitySample>& samples,
                           const std::vector<std::string>& origin) {
    StudyFiles files;
    files.markdown = "# Pose error of vision against its counts\n\n";
    for (const std::string& line : origin) files.markdown += "* " + line + "\n";
    files.csv = "count,low,high,samples,seen,motion_rmse_m\n";
    plot::Figure figure;
    figure.title = "Pose error of vision alone";
    figure.columns = 2;
    figure.panel_width = 440;
    figure.panel_height = 320;
    figure.footer = origin;
    for (const Axis& axis : kAxes) {
      const std::vector<QualityBin> bins = BinBy(samples, axis.count, axis.width, axis.bins);
      files.markdown += std::string("\n| lowest ") + axis.name +
                        " of a second | samples | vision in all images | RMSE of the motion over "
                        "that second, m |\n| --- | --- | --- | --- |\n";
      for (const QualityBin& b : bins) {
        const bool open = &b == &bins.back() && b.high == axis.width * axis.bins;
        const std::string range = open ? ">= " + std::to_string(b.low)
                                       : std::to_string(b.low) + " - " + std::to_string(b.high - 1);
        files.markdown += "| " + range + " | " + std::to_string(b.seconds) + " | " +
                          FormatFixed(100.0 * SeenShare(b), 0) + " % | " +
                          (b.seen > 0 ? FormatFixed(b.motion_rmse_m, 4) : "-") + " |\n";
        files.csv += std::string(axis.name) + "," + std::to_string(b.low) + "," +
                     std::to_string(b.high) + "," + std::to_string(b.seconds) + "," +
                     std::to_string(b.seen) + "," + FormatDouble(b.motion_rmse_m) + "\n";
      }
      figure.panels.push_back(
          PanelOf(axis, bins, "error of the motion over 1 s", "RMSE, m", [](const QualityBin& b) {
            return b.seen > 0 ? std::optional(b.motion_rmse_m) : std::nullopt;
          }));
      figure.panels.push_back(
          PanelOf(axis, bins, "seconds with vision in all images", "share",
                  [](const QualityBin& b) { return std::optional(SeenShare(b)); }));
      figure.panels.back().y_range = {0, 1.08};
    }
    files.drawing = plot::Draw(figure);
    return files;
  }

  static double SeenShare(const QualityBin& b) {
    return static_cast<double>(b.seen) / static_cast<double>(b.seconds);
  }

  // A panel over the bins; value gives what is drawn of one, empty to leave it out.
  template <typename Value>
  static plot::Panel PanelOf(const Axis& axis, const std::vector<QualityBin>& bins,
                             const char* title, const char* y_label, const Value& value) {
    plot::Panel panel;
    panel.title = title;
    panel.x_label = std::string("lowest ") + axis.name + " of the second (middle of the bin)";
    panel.x_range = {0, static_cast<double>(axis.width * axis.bins)};
    panel.y_label = y_label;
    plot::Series series;
    series.style = plot::Style::kLineAndPoints;
    double highest = 0;
    for (const QualityBin& b : bins) {
      const std::optional<double> y = value(b);
      if (!y) continue;
      series.x.push_back(0.5 * (b.low + b.high));
      series.y.push_back(*y);
      highest = std::max(highest, *y);
    }
    panel.series.push_back(std::move(series));
    panel.y_range = {0, 1.08 * highest};
    return panel;
  }

  std::vector<std::string> logs_, configs_;
};

}  // namespace

Result<std::vector<QualitySample>> QualitySamples(const measure::SlamRun& run,
                                                  const eval::Trajectory& truth) {
  const eval::EvalOptions options;
  const auto evaluation = eval::Evaluate(truth, run.Live(), options);
  if (!evaluation) return evaluation.error();
  std::map<Utime, const FramePose*> frames;
  for (const FramePose& f : run.frames) frames[f.utime] = &f;
  std::vector<QualitySample> out;
  size_t before = 0;
  for (const eval::PosePair& now : evaluation->pairs) {
    const Utime then = now.utime - options.rpe_delta;
    while (evaluation->pairs[before].utime < then) ++before;
    const eval::PosePair& begin = evaluation->pairs[before];
    if (begin.utime - then > DurationUs{options.rpe_delta.us / 10}) continue;
    QualitySample sample;
    sample.num_detected = sample.num_tracked = std::numeric_limits<int>::max();
    for (auto it = frames.find(begin.utime); it != frames.upper_bound(now.utime); ++it) {
      const FramePose& f = *it->second;
      sample.num_detected = std::min(sample.num_detected, f.num_detected);
      sample.num_tracked = std::min(sample.num_tracked, f.num_tracked);
      sample.seen &= f.status == TrackingStatus::kTracking || f.status == TrackingStatus::kDegraded;
    }
    sample.motion_m = eval::MotionError(begin, now).translation().norm();
    out.push_back(sample);
  }
  return out;
}

std::vector<QualityBin> BinBy(const std::vector<QualitySample>& samples, int QualitySample::*count,
                              int width, int num_bins) {
  std::vector<QualityBin> bins(num_bins);
  for (int i = 0; i < num_bins; ++i) {
    bins[i].low = i * width;
    bins[i].high = (i + 1) * width;
  }
  for (const QualitySample& s : samples) {
    QualityBin& bin = bins[std::min(s.*count / width, num_bins - 1)];
    ++bin.seconds;
    if (!s.seen) continue;
    ++bin.seen;
    bin.motion_rmse_m += s.motion_m * s.motion_m;
  }
  std::vector<QualityBin> out;
  for (QualityBin bin : bins) {
    if (bin.seconds == 0) continue;
    if (bin.seen > 0) {
      bin.motion_rmse_m = std::sqrt(bin.motion_rmse_m / static_cast<double>(bin.seen));
    }
    out.push_back(bin);
  }
  return out;
}

std::unique_ptr<Study> MakeQualityStudy() {
  return std::make_unique<QualityStudy>();
}

}  // namespace gw::study

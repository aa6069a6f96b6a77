#include "tools/study/quality.h"

#include <cmath>
#include <cstdio>
#include <map>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/eval/evaluate.h"
#include "tools/plot/svg.h"
#include "tools/study/study.h"

namespace gw::study {
namespace {

constexpr char kVariant[] = "none";
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
  void AddOptions(CLI::App& app) override {
    app.add_option("logs", logs_, "LCM event logs with ground truth")->required();
    app.add_option("--config", configs_, "robot YAML, once or once per log")->required();
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
    files.markdown = "# Pose error of the vision-only system against its counts\n\n";
    for (const std::string& line : origin) files.markdown += "* " + line + "\n";
    files.csv = "count,low,high,images,ape_rmse_m,motion_rmse_m\n";
    plot::Figure figure;
    figure.title = "Pose error of the vision-only system";
    figure.columns = 2;
    figure.panel_width = 440;
    figure.panel_height = 320;
    figure.footer = origin;
    for (const Axis& axis : kAxes) {
      const std::vector<QualityBin> bins = BinBy(samples, axis.count, axis.width, axis.bins);
      files.markdown += std::string("\n| ") + axis.name +
                        " | images | APE RMSE, m | RMSE of the motion over 1 s, m |\n"
                        "| --- | --- | --- | --- |\n";
      for (const QualityBin& b : bins) {
        const std::string range = std::to_string(b.low) + " - " + std::to_string(b.high - 1);
        files.markdown += "| " + range + " | " + std::to_string(b.images) + " | " +
                          FormatFixed(b.ape_rmse_m, 3) + " | " + FormatFixed(b.motion_rmse_m, 3) +
                          " |\n";
        files.csv += std::string(axis.name) + "," + std::to_string(b.low) + "," +
                     std::to_string(b.high) + "," + std::to_string(b.images) + "," +
                     FormatDouble(b.ape_rmse_m) + "," + FormatDouble(b.motion_rmse_m) + "\n";
      }
      for (double QualityBin::*error : {&QualityBin::ape_rmse_m, &QualityBin::motion_rmse_m}) {
        figure.panels.push_back(ErrorPanel(axis, bins, error));
      }
    }
    files.svg = plot::RenderSvg(figure);
    return files;
  }

  static plot::Panel ErrorPanel(const Axis& axis, const std::vector<QualityBin>& bins,
                                double QualityBin::*error) {
    const bool ape = error == &QualityBin::ape_rmse_m;
    plot::Panel panel;
    panel.title = ape ? "absolute position error" : "error of the motion over 1 s";
    panel.x_label = std::string(axis.name) + " (middle of the bin)";
    panel.y_label = "RMSE, m";
    plot::Series series;
    series.style = plot::Style::kLineAndPoints;
    double worst = 0;
    for (const QualityBin& b : bins) {
      series.x.push_back(0.5 * (b.low + b.high));
      series.y.push_back(b.*error);
      worst = std::max(worst, b.*error);
    }
    panel.series.push_back(std::move(series));
    panel.x_range = {0, static_cast<double>(axis.width * axis.bins)};
    panel.y_range = {0, 1.08 * worst};
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
  for (size_t i = 0; i < evaluation->pairs.size(); ++i) {
    const eval::PosePair& now = evaluation->pairs[i];
    const Utime then = now.utime - options.rpe_delta;
    while (evaluation->pairs[before].utime < then) ++before;
    if (evaluation->pairs[before].utime - then > DurationUs{options.rpe_delta.us / 10}) continue;
    const FramePose& f = *frames.at(now.utime);
    out.push_back({f.num_detected, f.num_tracked, evaluation->ape_m[i],
                   eval::MotionError(evaluation->pairs[before], now).translation().norm()});
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
    ++bin.images;
    bin.ape_rmse_m += s.ape_m * s.ape_m;
    bin.motion_rmse_m += s.motion_m * s.motion_m;
  }
  std::vector<QualityBin> out;
  for (QualityBin bin : bins) {
    if (bin.images == 0) continue;
    bin.ape_rmse_m = std::sqrt(bin.ape_rmse_m / static_cast<double>(bin.images));
    bin.motion_rmse_m = std::sqrt(bin.motion_rmse_m / static_cast<double>(bin.images));
    out.push_back(bin);
  }
  return out;
}

std::unique_ptr<Study> MakeQualityStudy() {
  return std::make_unique<QualityStudy>();
}

}  // namespace gw::study

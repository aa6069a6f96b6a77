#include "tools/study/repeat_run.h"

#include <algorithm>
#include <cstdio>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/eval/evaluate.h"
#include "tools/measure/measures.h"
#include "tools/plot/svg.h"
#include "tools/study/study.h"

namespace gw::study {
namespace {

constexpr const char* kVariants[] = {"da", "pe", "lba", "full"};

struct VariantResult {
  std::string variant;
  std::vector<std::vector<LapResult>> runs;  // per seed, per lap

  // Over the seeds.
  template <typename Value>
  double Median(size_t lap, Value value) const {
    std::vector<double> values;
    for (const auto& run : runs) values.push_back(value(run[lap]));
    return measure::Median(values);
  }
  double Frame(size_t lap) const {
    return Median(lap, [](const LapResult& r) { return r.frame_rmse_m; });
  }
  double Ratio(size_t lap) const {
    return Median(lap, [](const LapResult& r) { return r.ratio(); });
  }
};

class RepeatRunStudy : public Study {
 public:
  void AddOptions(CLI::App& app) override {
    app.add_option("log", log_, "LCM event log with ground truth")->required();
    app.add_option("--config", config_, "robot YAML")->required();
    app.add_option("--laps", laps_, "how often the log is driven in a row (3)")
        ->check(CLI::Range(2, 100));
    app.add_option("--seeds", seeds_, "runs per variant, of which the medians are shown (1)")
        ->check(CLI::Range(1, 100));
  }

  Result<StudyFiles> Run() override {
    auto experiment = LoadExperiment(log_, config_);
    if (!experiment) return experiment.error();
    std::vector<VariantResult> results;
    for (const char* variant : kVariants) {
      results.push_back({variant, {}});
      for (int seed = 0; seed < seeds_; ++seed) {
        auto laps = RunVariant(&*experiment, variant, seed);
        if (!laps) return laps.error();
        std::fprintf(stderr, "gw-study: %s, seed %d: lap %d RMSE %.4f m, R %.3f\n", variant, seed,
                     laps_, laps->back().frame_rmse_m, laps->back().ratio());
        results.back().runs.push_back(*std::move(laps));
      }
    }
    return Render(*experiment, results);
  }

 private:
  Result<std::vector<LapResult>> RunVariant(Experiment* experiment, const std::string& variant,
                                            int seed) const {
    const auto config = ConfigFor(*experiment, variant);
    if (!config) return config.error();
    auto session = tools::SlamSession::Create(*config);
    if (!session) return session.error();
    const auto run = tools::RunLaps(experiment->path, laps_, {.seed = seed, .span = {}}, &*session);
    if (!run) return run.error();
    if (static_cast<int>(run->laps.size()) < laps_) {
      return Error{ErrorCode::kBadData, experiment->path + ": no image that can be used"};
    }
    experiment->dr_synthetic |= session->dr_synthetic();
    return MeasureLaps(experiment->truth, *session, run->laps);
  }

  StudyFiles Render(const Experiment& experiment, const std::vector<VariantResult>& results) const {
    StudyFiles files;
    files.csv =
        "variant,seed,lap,frame_rmse_m,keyframe_rmse_m,ratio,known_share,keyframes,landmarks\n";
    for (const VariantResult& v : results) {
      for (size_t seed = 0; seed < v.runs.size(); ++seed) {
        for (size_t lap = 0; lap < v.runs[seed].size(); ++lap) {
          const LapResult& r = v.runs[seed][lap];
          files.csv += v.variant + "," + std::to_string(seed) + "," + std::to_string(lap + 1) +
                       "," + FormatFixed(r.frame_rmse_m, 4) + "," +
                       FormatFixed(r.keyframe_rmse_m, 4) + "," + FormatFixed(r.ratio(), 3) + "," +
                       FormatFixed(r.known_share, 4) + "," + std::to_string(r.keyframes) + "," +
                       std::to_string(r.landmarks) + "\n";
        }
      }
    }
    files.markdown = "# Repeat run: the same way " + std::to_string(laps_) +
                     " times, the map kept\n\n" + Origin(experiment) +
                     ". Frame RMSE: poses as published live, m; R(F/KF): over the RMSE of all "
                     "keyframes when the lap ends; each aligned on its own.\n\n| variant |";
    std::string rule = "\n| --- |";
    for (const char* what : {"RMSE, lap ", "R, lap "}) {
      for (int lap = 1; lap <= laps_; ++lap) {
        files.markdown += std::string(" ") + what + std::to_string(lap) + " |";
        rule += " --- |";
      }
    }
    files.markdown += rule + "\n";
    for (const VariantResult& v : results) {
      files.markdown += "| " + v.variant + " |";
      for (size_t lap = 0; lap < static_cast<size_t>(laps_); ++lap) {
        files.markdown += " " + FormatFixed(v.Frame(lap), 4) + " |";
      }
      for (size_t lap = 0; lap < static_cast<size_t>(laps_); ++lap) {
        files.markdown += " " + FormatFixed(v.Ratio(lap), 3) + " |";
      }
      files.markdown += "\n";
    }
    files.svg = Plot(experiment, results);
    return files;
  }

  std::string Origin(const Experiment& experiment) const {
    std::string out = Describe(experiment) + ", " + std::to_string(seeds_) + " seeds, gw-study " +
                      Version() + ", configuration";
    for (const char* variant : kVariants) {
      out += std::string(" ") + variant + " " + ConfigHashText(*ConfigFor(experiment, variant));
    }
    return out;
  }

  std::string Plot(const Experiment& experiment, const std::vector<VariantResult>& results) const {
    plot::Panel rmse, ratio;
    rmse.title = "frame RMSE";
    rmse.y_label = "m";
    ratio.title = "R(F/KF)";
    ratio.y_label = "frame RMSE / keyframe RMSE";
    for (plot::Panel* panel : {&rmse, &ratio}) {
      panel->x_label = "lap";
      panel->x_range = {0.5, laps_ + 0.5};
      double top = 0;
      for (const VariantResult& v : results) {
        plot::Series series;
        series.label = v.variant;
        for (int lap = 0; lap < laps_; ++lap) {
          const auto index = static_cast<size_t>(lap);
          series.x.push_back(lap + 1);
          series.y.push_back(panel == &rmse ? v.Frame(index) : v.Ratio(index));
          top = std::max(top, series.y.back());
        }
        panel->series.push_back(std::move(series));
      }
      panel->y_range = {0, 1.1 * top};
    }
    plot::Figure figure;
    figure.title = "Repeat run";
    figure.panels = {rmse, ratio};
    figure.footer = {Origin(experiment)};
    return plot::RenderSvg(figure);
  }

  std::string log_, config_;
  int laps_ = 3;
  int seeds_ = 1;
};

}  // namespace

Result<std::vector<LapResult>> MeasureLaps(const eval::Trajectory& truth,
                                           const tools::SlamSession& session,
                                           const std::vector<tools::Lap>& laps) {
  std::vector<LapResult> out;
  for (const tools::Lap& lap : laps) {
    eval::Trajectory frames, keyframes;
    int64_t known = 0;
    for (size_t i = lap.frames_begin; i < lap.frames_end; ++i) {
      const FramePose& f = session.frames()[i];
      frames.push_back({f.utime - lap.shift, f.T_WB});
      known += f.status != TrackingStatus::kLost && f.status != TrackingStatus::kInitializing;
    }
    for (const tools::TimedKeyframe& k : lap.poses) {
      keyframes.push_back({k.utime, k.T_WC * session.camera().T_BC.inverse()});
    }
    const auto of_frames = eval::Evaluate(truth, frames, {});
    if (!of_frames) return of_frames.error();
    const auto of_keyframes = eval::Evaluate(truth, keyframes, {});
    if (!of_keyframes) return of_keyframes.error();
    LapResult result;
    result.frame_rmse_m = of_frames->ape_translation_m.rmse;
    result.keyframe_rmse_m = of_keyframes->ape_translation_m.rmse;
    result.known_share = static_cast<double>(known) / static_cast<double>(frames.size());
    result.keyframes = lap.keyframes;
    result.landmarks = lap.landmarks;
    out.push_back(result);
  }
  return out;
}

std::unique_ptr<Study> MakeRepeatRunStudy() {
  return std::make_unique<RepeatRunStudy>();
}

}  // namespace gw::study

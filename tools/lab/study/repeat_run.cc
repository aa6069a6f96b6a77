#include "tools/lab/study/repeat_run.h"

#include <algorithm>
#include <cstdio>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/eval/evaluate.h"
#include "tools/lab/measure/measures.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

struct VariantResult {
  std::string variant;
  std::vector<std::vector<LapResult>> runs;  // per seed, per lap
  GrowthRun growth;                          // of the first seed

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
  void AddOptions(cli::Command& app) override {
    app.AddOption("log", log_, "LCM event log with ground truth")->Required();
    app.AddOption("--config", config_, "robot YAML")->Required();
    app.AddOption("--laps", laps_, "how often the log is driven in a row (3)")->InRange(2, 100);
    app.AddOption("--seeds", seeds_, "runs per variant, of which the medians are shown (1)")
        ->InRange(1, 100);
    app.AddOption("--variants", variants_, "which (da pe lba full), as in gw-slam --variant");
  }

  Result<StudyFiles> Run() override {
    auto experiment = LoadExperiment(log_, config_);
    if (!experiment) return experiment.error();
    std::vector<VariantResult> results;
    for (const std::string& variant : variants_) {
      results.push_back({variant, {}, {variant, {}}});
      for (int seed = 0; seed < seeds_; ++seed) {
        GrowthMeter meter(ResidentMegabytes);
        auto laps = RunVariant(&*experiment, variant, seed, &meter);
        if (!laps) return laps.error();
        if (seed == 0) results.back().growth.samples = meter.samples();
        std::fprintf(stderr, "gw-study: %s, seed %d: lap %d RMSE %.4f m, R %.3f\n", variant.c_str(),
                     seed, laps_, laps->back().frame_rmse_m, laps->back().ratio());
        results.back().runs.push_back(*std::move(laps));
      }
    }
    return Render(*experiment, results);
  }

 private:
  Result<std::vector<LapResult>> RunVariant(Experiment* experiment, const std::string& variant,
                                            int seed, GrowthMeter* meter) const {
    const auto config = ConfigFor(*experiment, variant);
    if (!config) return config.error();
    auto session = tools::SlamSession::Create(*config);
    if (!session) return session.error();
    session->MeasureTimes(ThreadCpuMicroseconds);
    const auto run =
        tools::RunLaps(experiment->path, laps_, {.seed = seed, .span = {}}, &*session,
                       [&](const process::LogEvent&, double) { meter->Observe(*session); });
    if (!run) return run.error();
    if (static_cast<int>(run->laps.size()) < laps_) {
      return Error{ErrorCode::kBadData, experiment->path + ": no image that can be used"};
    }
    experiment->dr_synthetic |= session->dr_synthetic();
    return MeasureLaps(experiment->truth, *session, run->laps, meter->samples());
  }

  StudyFiles Render(const Experiment& experiment, const std::vector<VariantResult>& results) const {
    StudyFiles files;
    files.csv =
        "variant,seed,lap,frame_rmse_m,keyframe_rmse_m,ratio,known_share,keyframes,landmarks,"
        "resident_mb,tracking_p99_ms,local_ba_median_ms\n";
    for (const VariantResult& v : results) {
      for (size_t seed = 0; seed < v.runs.size(); ++seed) {
        for (size_t lap = 0; lap < v.runs[seed].size(); ++lap) {
          const LapResult& r = v.runs[seed][lap];
          files.csv +=
              v.variant + "," + std::to_string(seed) + "," + std::to_string(lap + 1) + "," +
              FormatFixed(r.frame_rmse_m, 4) + "," + FormatFixed(r.keyframe_rmse_m, 4) + "," +
              FormatFixed(r.ratio(), 3) + "," + FormatFixed(r.known_share, 4) + "," +
              std::to_string(r.cost.keyframes) + "," + std::to_string(r.cost.landmarks) + "," +
              FormatFixed(r.cost.resident_mb, 1) + "," + FormatFixed(r.cost.tracking_p99_ms, 2) +
              "," + FormatFixed(r.cost.local_ba_ms, 1) + "\n";
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
    files.markdown += CostTable(results.back());
    files.drawing = Plot(experiment, results);
    return files;
  }

  // Costs of the variant's first seed, lap by lap, each quantity with its growth over the lap
  // before.
  static std::string CostTable(const VariantResult& result) {
    std::string out =
        "\nWhat `" + result.variant +
        "` costs (map when the lap ends, CPU times over the lap; in brackets the "
        "growth over the lap before):\n\n| lap | keyframes | landmarks | memory, MB | "
        "front-end p99, ms | local BA median, ms |\n| --- | --- | --- | --- | --- | "
        "--- |\n";
    const std::vector<LapResult>& laps = result.runs.front();
    for (size_t lap = 0; lap < laps.size(); ++lap) {
      const GrowthSample& now = laps[lap].cost;
      const GrowthSample* before = lap > 0 ? &laps[lap - 1].cost : nullptr;
      const auto cell = [&](auto quantity, int decimals) {
        std::string text = " " + FormatFixed(static_cast<double>(now.*quantity), decimals);
        if (before != nullptr && before->*quantity > 0) {
          const double growth =
              static_cast<double>(now.*quantity) / static_cast<double>(before->*quantity) - 1.0;
          text += " (" + std::string(growth >= 0 ? "+" : "") + FormatFixed(100 * growth, 1) + " %)";
        }
        return text + " |";
      };
      out += "| " + std::to_string(lap + 1) + " |" + cell(&GrowthSample::keyframes, 0) +
             cell(&GrowthSample::landmarks, 0) + cell(&GrowthSample::resident_mb, 0) +
             cell(&GrowthSample::tracking_p99_ms, 2) + cell(&GrowthSample::local_ba_ms, 1) + "\n";
    }
    return out;
  }

  std::string Origin(const Experiment& experiment) const {
    std::string out = Describe(experiment) + ", " + std::to_string(seeds_) + " seeds, gw-study " +
                      Version() + ", configuration";
    for (const std::string& variant : variants_) {
      out += std::string(" ") + variant + " " + ConfigHashText(*ConfigFor(experiment, variant));
    }
    return out;
  }

  plot::Drawing Plot(const Experiment& experiment,
                     const std::vector<VariantResult>& results) const {
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
    figure.columns = 2;
    figure.panels = {rmse, ratio};
    std::vector<GrowthRun> growth;
    for (const VariantResult& v : results) growth.push_back(v.growth);
    for (plot::Panel& panel : GrowthPanels(growth)) figure.panels.push_back(std::move(panel));
    figure.footer = {Origin(experiment)};
    return plot::Draw(figure);
  }

  std::string log_, config_;
  std::vector<std::string> variants_ = {"da", "pe", "lba", "full"};
  int laps_ = 3;
  int seeds_ = 1;
};

}  // namespace

Result<std::vector<LapResult>> MeasureLaps(const eval::Trajectory& truth,
                                           const tools::SlamSession& session,
                                           const std::vector<tools::Lap>& laps,
                                           const std::vector<GrowthSample>& samples) {
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
    result.cost = OfLap(samples, session, lap);
    out.push_back(result);
  }
  return out;
}

std::unique_ptr<Study> MakeRepeatRunStudy() {
  return std::make_unique<RepeatRunStudy>();
}

}  // namespace gw::study

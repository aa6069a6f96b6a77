// Study "latency" (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, section IV, runtime):
// front-end time per image of `none` and `full` on one log.
//
// Both run in this process over the same events at the same time, image by image, the order swapped
// with every image: whatever else the machine does hits both alike. Medians of single runs on a
// busy machine differ by more than what is looked for; the ratio of interleaved ones does not.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>

#include "common/core/format.h"
#include "common/core/version.h"
#include "common/wire/channels.h"
#include "tools/lab/measure/measures.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

constexpr const char* kVariants[] = {"none", "full"};

int64_t SteadyMicroseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Repeat {
  std::vector<double> ms[2];  // per image, of kVariants
  // Time of the full variant over that of the vision-only one.
  double ratio() const { return measure::Median(ms[1]) / measure::Median(ms[0]); }
};

class LatencyStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("log", log_, "LCM event log with ground truth")->Required();
    app.AddOption("--config", config_, "robot YAML")->Required();
    app.AddOption("--repeats", repeats_, "how often the log is run (3)")->InRange(1, 100);
  }

  Result<StudyFiles> Run() override {
    auto experiment = LoadExperiment(log_, config_);
    if (!experiment) return experiment.error();
    std::vector<Repeat> repeats;
    for (int i = 0; i < repeats_; ++i) {
      auto repeat = RunBoth(&*experiment);
      if (!repeat) return repeat.error();
      repeats.push_back(*std::move(repeat));
      std::fprintf(stderr, "gw-study: run %d of %d: ratio %.4f\n", i + 1, repeats_,
                   repeats.back().ratio());
    }
    return Render(*experiment, repeats);
  }

 private:
  Result<Repeat> RunBoth(Experiment* experiment) {
    std::vector<tools::SlamSession> sessions;
    for (const char* variant : kVariants) {
      const auto config = ConfigFor(*experiment, variant);
      if (!config) return config.error();
      auto session = tools::SlamSession::Create(*config);
      if (!session) return session.error();
      sessions.push_back(*std::move(session));
      sessions.back().MeasureTimes(SteadyMicroseconds);
    }
    auto log = process::EventLogReader::Open(experiment->path);
    if (!log) return log.error();
    bool swapped = false;
    while (const auto event = log->Next()) {
      sessions[swapped ? 1 : 0].Process(*event);
      sessions[swapped ? 0 : 1].Process(*event);
      if (event->channel == wire::kCamera) swapped = !swapped;
    }
    if (log->error()) return *log->error();
    Repeat out;
    for (int v = 0; v < 2; ++v) {
      if (sessions[v].frames().empty()) {
        return Error{ErrorCode::kBadData, experiment->path + ": no image that can be used"};
      }
      experiment->dr_synthetic |= sessions[v].dr_synthetic();
      for (const int64_t us : sessions[v].tracking_us()) {
        out.ms[v].push_back(static_cast<double>(us) * 1e-3);
      }
    }
    return out;
  }

  StudyFiles Render(const Experiment& experiment, const std::vector<Repeat>& repeats) const {
    std::vector<double> all[2];
    std::vector<double> ratios;
    for (const Repeat& r : repeats) {
      for (int v = 0; v < 2; ++v) all[v].insert(all[v].end(), r.ms[v].begin(), r.ms[v].end());
      ratios.push_back(r.ratio());
    }
    const double ratio = measure::Median(all[1]) / measure::Median(all[0]);
    StudyFiles files;
    files.csv = "repeat,images,none_median_ms,none_p99_ms,full_median_ms,full_p99_ms,ratio\n";
    for (size_t i = 0; i < repeats.size(); ++i) {
      files.csv += std::to_string(i + 1) + "," + std::to_string(repeats[i].ms[0].size());
      for (const auto& ms : repeats[i].ms) {
        files.csv += "," + FormatFixed(measure::Median(ms), 3) + "," +
                     FormatFixed(measure::Quantile(ms, 0.99), 3);
      }
      files.csv += "," + FormatFixed(repeats[i].ratio(), 4) + "\n";
    }
    const auto [low, high] = std::minmax_element(ratios.begin(), ratios.end());
    files.markdown = "# Tracking time with and without Good Weights\n\n" + Origin(experiment) +
                     "; both variants interleaved image by image, " +
                     std::to_string(repeats.size()) + " runs of " +
                     std::to_string(repeats[0].ms[0].size()) +
                     " images\n\n| variant | median, ms | p99, ms |\n| --- | --- | --- |\n";
    for (int v = 0; v < 2; ++v) {
      files.markdown += std::string("| ") + kVariants[v] + " | " +
                        FormatFixed(measure::Median(all[v]), 2) + " | " +
                        FormatFixed(measure::Quantile(all[v], 0.99), 2) + " |\n";
    }
    files.markdown += "\nRatio of the medians, full / none: **" + FormatFixed(ratio, 3) +
                      "** (single runs " + FormatFixed(*low, 3) + " - " + FormatFixed(*high, 3) +
                      ").\n";
    files.drawing = Plot(experiment, all, ratio);
    return files;
  }

  std::string Origin(const Experiment& experiment) const {
    std::string out = Describe(experiment) + ", seed 0, gw-study " + Version() + ", configuration";
    for (const char* variant : kVariants) {
      out += std::string(" ") + variant + " " + ConfigHashText(*ConfigFor(experiment, variant));
    }
    return out;
  }

  plot::Drawing Plot(const Experiment& experiment, const std::vector<double> (&all)[2],
                     double ratio) const {
    plot::Panel panel;
    panel.title = "share of the images that took at most this long";
    panel.x_label = "front-end time, ms";
    panel.y_label = "share, %";
    panel.y_range = {0, 100};
    double longest = 0;
    for (int v = 0; v < 2; ++v) {
      plot::Series series;
      series.label = kVariants[v];
      for (int percent = 0; percent <= 99; ++percent) {
        series.x.push_back(measure::Quantile(all[v], percent / 100.0));
        series.y.push_back(percent);
      }
      longest = std::max(longest, series.x.back());
      panel.series.push_back(std::move(series));
    }
    panel.x_range = {0, 1.05 * longest};
    plot::Figure figure;
    figure.title = "Tracking time: full / none = " + FormatFixed(ratio, 3) + " (medians)";
    figure.panel_width = 720;
    figure.panels = {panel};
    figure.footer = {Origin(experiment)};
    return plot::Draw(figure);
  }

  std::string log_, config_;
  int repeats_ = 3;
};

}  // namespace

std::unique_ptr<Study> MakeLatencyStudy() {
  return std::make_unique<LatencyStudy>();
}

}  // namespace gw::study

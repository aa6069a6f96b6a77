#include "tools/lab/study/alpha_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/eval/evaluate.h"
#include "tools/lab/measure/measures.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

constexpr int kLowest = -4;  // of log10 alpha
constexpr int kHighest = 6;

struct SpanResult {
  std::string name;  // "weak", "well"
  std::string text;  // T0:T1 as given
  std::vector<AlphaResult> fixed;
  std::vector<double> adaptive_m;  // per run
  double dr_m = 0;
  double mean_q = 0;  // of the adaptive runs
};

class AlphaSweepStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("log", log_, "LCM event log with ground truth")->Required();
    app.AddOption("--config", config_, "robot YAML")->Required();
    app.AddOption("--weak", weak_, "T0:T1, s from the begin: a span that is tracked poorly")
        ->Required();
    app.AddOption("--well", well_, "T0:T1: a span that is tracked well")->Required();
    app.AddOption("--runs", runs_, "with perturbed starts, seeds 0, 1, ... (5)")->InRange(1, 100);
  }

  Result<StudyFiles> Run() override {
    auto experiment = LoadExperiment(log_, config_);
    if (!experiment) return experiment.error();
    std::vector<SpanResult> spans;
    for (const auto& [name, text] : {std::pair("weak", weak_), std::pair("well", well_)}) {
      const auto span = tools::ParseSpan(std::string("--") + name, text);
      if (!span) return span.error();
      auto result = Sweep(&*experiment, span->span);
      if (!result) return result.error();
      result->name = name;
      result->text = text;
      spans.push_back(*std::move(result));
    }
    return Render(*experiment, spans);
  }

 private:
  Result<SpanResult> Sweep(Experiment* experiment, const tools::Span& span) const {
    SpanResult out;
    std::vector<double> dr_m;
    int64_t images = 0;
    for (int seed = 0; seed < runs_; ++seed) {
      const auto run = study::Run(experiment, "full", {seed, span});
      if (!run) return run.error();
      const auto rmse = DriftRmse(experiment->truth, run->Live());
      if (!rmse) return rmse.error();
      out.adaptive_m.push_back(*rmse);
      const auto dr = DriftRmse(experiment->truth, run->DeadReckoning());
      if (!dr) return Error{dr.error().code, experiment->path + ": no dead reckoning in the span"};
      dr_m.push_back(*dr);
      for (const FramePose& f : run->frames) out.mean_q += f.q;
      images += static_cast<int64_t>(run->frames.size());
    }
    out.mean_q /= static_cast<double>(images);
    out.dr_m = measure::Median(dr_m);
    for (int exponent = kLowest; exponent <= kHighest; ++exponent) {
      AlphaResult result{exponent, {}};
      for (int seed = 0; seed < runs_; ++seed) {
        const auto run =
            study::Run(experiment, "fixed:1e" + std::to_string(exponent), {seed, span});
        if (!run) return run.error();
        const auto rmse = DriftRmse(experiment->truth, run->Live());
        if (!rmse) return rmse.error();
        result.rmse_m.push_back(*rmse);
      }
      std::fprintf(stderr, "gw-study: alpha 1e%d: median %.4f m\n", exponent,
                   measure::Median(result.rmse_m));
      out.fixed.push_back(std::move(result));
    }
    return out;
  }

  std::vector<std::string> Origin(const Experiment& experiment) const {
    return {Describe(experiment) + ", seeds 0 - " + std::to_string(runs_ - 1) + ", gw-study " +
                Version(),
            "configuration: full " + ConfigHashText(*ConfigFor(experiment, "full")) + ", fixed:1 " +
                ConfigHashText(*ConfigFor(experiment, "fixed:1"))};
  }

  StudyFiles Render(const Experiment& experiment, const std::vector<SpanResult>& spans) const {
    StudyFiles files;
    files.markdown = "# Pose error against a fixed scale of the DR information\n\n";
    for (const std::string& line : Origin(experiment)) files.markdown += "* " + line + "\n";
    files.markdown += "* error: RMSE of the positions, the first poses put together\n";
    files.csv = "span,variant,log10_alpha,seed,rmse_m\n";
    plot::Figure figure;
    figure.title = "Fixed scale of the DR information";
    figure.columns = 2;
    figure.panel_width = 520;
    figure.footer = Origin(experiment);
    for (const SpanResult& span : spans) {
      const double adaptive = measure::Median(span.adaptive_m);
      const AlphaResult& best = BestOf(span.fixed);
      files.markdown += "\n## " + span.name + ": " + span.text + " s, mean Q " +
                        FormatFixed(span.mean_q, 2) +
                        "\n\n| log10 alpha | median, m | min - max, m |\n| --- | --- | --- |\n";
      for (const AlphaResult& r : span.fixed) {
        files.markdown += MarkdownRow(std::to_string(r.log10_alpha), r.rmse_m);
        AppendCsv(span.name, "fixed", std::to_string(r.log10_alpha), r.rmse_m, &files.csv);
      }
      files.markdown += MarkdownRow("adaptive (`full`)", span.adaptive_m);
      AppendCsv(span.name, "full", "", span.adaptive_m, &files.csv);
      files.markdown += "| dead reckoning alone | " + FormatFixed(span.dr_m, 4) + " | |\n";
      AppendCsv(span.name, "dr_alone", "", {span.dr_m}, &files.csv);
      files.markdown += "\nAdaptive against the best fixed scale (1e" +
                        std::to_string(best.log10_alpha) + "): **" +
                        FormatFixed(adaptive / measure::Median(best.rmse_m), 2) +
                        "** times its error.\n";
      figure.panels.push_back(PanelOf(experiment, span));
    }
    files.drawing = plot::Draw(figure);
    return files;
  }

  static std::string MarkdownRow(const std::string& name, const std::vector<double>& rmse) {
    const auto [low, high] = std::minmax_element(rmse.begin(), rmse.end());
    return "| " + name + " | " + FormatFixed(measure::Median(rmse), 4) + " | " +
           FormatFixed(*low, 4) + " - " + FormatFixed(*high, 4) + " |\n";
  }

  static void AppendCsv(const std::string& span, const std::string& variant,
                        const std::string& alpha, const std::vector<double>& rmse,
                        std::string* csv) {
    for (size_t seed = 0; seed < rmse.size(); ++seed) {
      *csv += span + "," + variant + "," + alpha + "," + std::to_string(seed) + "," +
              FormatDouble(rmse[seed]) + "\n";
    }
  }

  static plot::Panel PanelOf(const Experiment& experiment, const SpanResult& span) {
    plot::Panel panel;
    panel.title = (span.name == "weak" ? "poorly tracked: " : "well tracked: ") + span.text +
                  " s, mean Q " + FormatFixed(span.mean_q, 2);
    panel.x_label = "log10 alpha";
    panel.y_label = "RMSE, m";
    panel.x_range = {kLowest - 0.5, kHighest + 0.5};
    plot::Series runs;
    runs.label = "single runs";
    runs.style = plot::Style::kPoints;
    runs.color = "#56b4e9";
    plot::Series medians;
    medians.label = "median, fixed";
    medians.dashed = true;
    medians.style = plot::Style::kLineAndPoints;
    medians.color = "#0072b2";
    const double adaptive = measure::Median(span.adaptive_m);
    double top = std::max(span.dr_m, adaptive);
    for (const AlphaResult& r : span.fixed) {
      for (const double rmse : r.rmse_m) {
        runs.x.push_back(r.log10_alpha);
        runs.y.push_back(rmse);
      }
      medians.x.push_back(r.log10_alpha);
      medians.y.push_back(measure::Median(r.rmse_m));
      top = std::max(top, medians.y.back());
    }
    panel.y_range = {0,
                     1.5 * top};  // room for the legend; a run far off is cut, not the rest shrunk
    const auto level = [](const char* label, double y, const char* color) {
      plot::Series line;
      line.label = label;
      line.x = {kLowest - 0.5, kHighest + 0.5};
      line.y = {y, y};
      line.color = color;
      return line;
    };
    panel.series = {runs, medians, level("dead reckoning alone", span.dr_m, "#d55e00"),
                    level("adaptive (full)", adaptive, "#000000")};
    bool labelled = false;
    for (const double bound : {experiment.config.frontend.dr_weight.alpha_min,
                               experiment.config.frontend.dr_weight.alpha_max}) {
      plot::Series line;
      if (!labelled) line.label = "alpha_min, alpha_max";
      labelled = true;
      line.x = {std::log10(bound), std::log10(bound)};
      line.y = {0, 1.5 * top};
      line.color = "#009e73";
      line.dashed = true;
      panel.series.push_back(std::move(line));
    }
    return panel;
  }

  std::string log_, config_, weak_, well_;
  int runs_ = 5;
};

}  // namespace

Result<double> DriftRmse(const eval::Trajectory& truth, const eval::Trajectory& est) {
  const eval::EvalOptions options;
  const std::vector<eval::PosePair> pairs =
      eval::Associate(truth, est, options.max_gap, options.max_diff);
  if (pairs.empty()) {
    return Error{ErrorCode::kBadData, "no pose of the span has ground truth at its time"};
  }
  const SE3 T_RefEst = pairs.front().T_ref * pairs.front().T_est.inverse();
  double sum = 0;
  for (const eval::PosePair& pair : pairs) {
    sum += (pair.T_ref.translation() - T_RefEst * pair.T_est.translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

const AlphaResult& BestOf(const std::vector<AlphaResult>& results) {
  return *std::min_element(results.begin(), results.end(),
                           [](const AlphaResult& a, const AlphaResult& b) {
                             return measure::Median(a.rmse_m) < measure::Median(b.rmse_m);
                           });
}

std::unique_ptr<Study> MakeAlphaSweepStudy() {
  return std::make_unique<AlphaSweepStudy>();
}

}  // namespace gw::study

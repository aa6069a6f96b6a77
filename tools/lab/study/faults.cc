// Studies "dr-faults" and "vision-faults": a log with one fault after the other in it, and what
// becomes of the pose. fault_cases.h says which faults, fault_table.h what each may do.
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/study/fault_cases.h"
#include "tools/lab/study/fault_table.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

// Vision alone is healthy on a log when it has a pose for all images but so many.
constexpr double kHealthyLoss = 0.01;

// The log without a fault.
struct Sound {
  std::vector<FaultRun> full;  // one per seed
  std::optional<double> full_m, none_m;
  double too_sure_s = 0;
  bool vision_healthy = false;
  DeadReckoning dr;
};

std::optional<double> Mean(const std::vector<std::optional<double>>& values) {
  double sum = 0;
  for (const auto& value : values) {
    if (!value) return std::nullopt;
    sum += *value;
  }
  return sum / static_cast<double>(values.size());
}

class FaultStudy : public Study {
 public:
  explicit FaultStudy(FaultMatrix matrix) : matrix_(matrix) {}

  void AddOptions(cli::Command& app) override {
    app.AddOption("log", log_, "LCM event log with ground truth")->Required();
    app.AddOption("--config", config_, "robot YAML")->Required();
    app.AddOption("--faults", names_, "some of them, separated by commas (all)")->Separator(',');
    app.AddOption("--from", from_s_,
                  "s since the begin of the log: faults begin then, and none of the configuration "
                  "are tried (0: from the begin)")
        ->NotNegative();
    app.AddOption("--runs", runs_, "seeds of each (1)")->InRange(1, 100);
    app.AddChoice<eval::Alignment>("--align", alignment_,
                                   {{"se3", eval::Alignment::kSe3}, {"yaw", eval::Alignment::kYaw}},
                                   "se3 (default), yaw: for a way along a line");
  }

  Result<StudyFiles> Run() override {
    auto experiment = LoadExperiment(log_, config_);
    if (!experiment) return experiment.error();
    const DurationUs length = experiment->truth.back().utime - experiment->truth.front().utime;
    const DurationUs from = DurationFromSeconds(from_s_);
    const auto cases = ChooseCases(FaultCases(matrix_, experiment->config, length, from), names_);
    if (!cases) return cases.error();
    const auto sound = RunSound(&*experiment);
    if (!sound) return sound.error();
    std::vector<FaultRow> rows;
    for (const FaultCase& fault : *cases) {
      auto row = RunCase(&*experiment, *sound, fault);
      if (!row) return row.error();
      Tell(*sound, *row);
      rows.push_back(*std::move(row));
    }
    const std::string origin = Describe(*experiment) + ", " + std::to_string(runs_) +
                               (runs_ == 1 ? " start" : " starts") + ", gw-study " + Version() +
                               ", configuration " + ConfigHashText(experiment->config);
    return RenderFaults(matrix_, sound->vision_healthy, origin, sound->too_sure_s, rows);
  }

 private:
  static Result<RobotConfig> Variant(RobotConfig config, const std::string& variant) {
    Experiment experiment;
    experiment.config = std::move(config);
    return ConfigFor(experiment, variant);
  }

  // `variant` on the log with the fault, one run per seed.
  Result<std::vector<FaultRun>> RunSeeds(Experiment* experiment, const RobotConfig& config,
                                         const fault::FaultPlan& plan,
                                         const std::string& variant) const {
    const auto chosen = Variant(config, variant);
    if (!chosen) return chosen.error();
    std::vector<FaultRun> out;
    for (int seed = 0; seed < runs_; ++seed) {
      auto run = RunWithFault(experiment, *chosen, plan, seed);
      if (!run) return run.error();
      out.push_back(*std::move(run));
    }
    return out;
  }

  std::optional<double> MeanApe(const Experiment& experiment, const std::vector<FaultRun>& runs,
                                const SE3& T_BB) const {
    std::vector<std::optional<double>> apes;
    for (const FaultRun& run : runs) {
      apes.push_back(MeasureFault(run.run, T_BB, experiment.truth, alignment_).ape_m);
    }
    return Mean(apes);
  }

  Result<Sound> RunSound(Experiment* experiment) const {
    Sound out;
    auto full = RunSeeds(experiment, experiment->config, {}, "full");
    if (!full) return full.error();
    out.full = *std::move(full);
    const auto none = RunSeeds(experiment, experiment->config, {}, "none");
    if (!none) return none.error();
    out.full_m = MeanApe(*experiment, out.full, SE3());
    out.none_m = MeanApe(*experiment, *none, SE3());
    out.vision_healthy = true;
    for (int seed = 0; seed < runs_; ++seed) {
      const auto i = static_cast<size_t>(seed);
      const auto of_full = MeasureFault(out.full[i].run, SE3(), experiment->truth, alignment_);
      out.too_sure_s = std::max(out.too_sure_s, of_full.too_sure_s);
      const auto of_none = MeasureFault((*none)[i].run, SE3(), experiment->truth, alignment_);
      out.vision_healthy &= static_cast<double>(of_none.without_pose) <=
                            kHealthyLoss * static_cast<double>(of_none.images);
    }
    auto dr = ReckonWithFault(*experiment, experiment->config, {});
    if (!dr) return dr.error();
    out.dr = *std::move(dr);
    return out;
  }

  Result<FaultRow> RunCase(Experiment* experiment, const Sound& sound,
                           const FaultCase& fault) const {
    FaultRow row;
    row.name = fault.name;
    row.text = fault.text;
    row.guilty = fault.guilty;
    row.sound_full_m = sound.full_m;
    row.none_m = sound.none_m;
    const auto full = RunSeeds(experiment, fault.config, fault.plan, "full");
    if (!full) return full.error();
    const Utime begin = experiment->truth.front().utime + fault.begin;
    const Utime visible = std::max(begin, FirstMotion(experiment->truth));
    for (size_t i = 0; i < full->size(); ++i) {
      const FaultRun& run = (*full)[i];
      row.full.push_back({MeasureFault(run.run, fault.T_BB, experiment->truth, alignment_),
                          SayingsOf(run.findings, sound.full[i].findings, visible),
                          run.explanation});
    }
    DeadReckoning dr = sound.dr;
    if (matrix_ == FaultMatrix::kDr) {
      auto faulty = ReckonWithFault(*experiment, fault.config, fault.plan);
      if (!faulty) return faulty.error();
      dr = *std::move(faulty);
    } else {
      const auto none = RunSeeds(experiment, fault.config, fault.plan, "none");
      if (!none) return none.error();
      row.none_m = MeanApe(*experiment, *none, fault.T_BB);
    }
    row.dr_m = Ape(experiment->truth, dr.filter, alignment_);
    row.wheels_m = Ape(experiment->truth, dr.wheels, alignment_);
    return row;
  }

  void Tell(const Sound& sound, const FaultRow& row) const {
    const FaultVerdict verdict = Judge(matrix_, sound.vision_healthy, row);
    std::string misses;
    for (const std::string& miss : verdict.misses) misses += " " + miss;
    std::fprintf(stderr, "gw-study: %s: %.4f m, %.2f of the bar:%s\n", row.name.c_str(),
                 verdict.full_m.value_or(NAN), verdict.ratio.value_or(NAN),
                 misses.empty() ? " met" : misses.c_str());
  }

  FaultMatrix matrix_;
  std::string log_, config_;
  std::vector<std::string> names_;
  double from_s_ = 0;
  int runs_ = 1;
  eval::Alignment alignment_ = eval::Alignment::kSe3;
};

}  // namespace

std::unique_ptr<Study> MakeDrFaultsStudy() {
  return std::make_unique<FaultStudy>(FaultMatrix::kDr);
}
std::unique_ptr<Study> MakeVisionFaultsStudy() {
  return std::make_unique<FaultStudy>(FaultMatrix::kVision);
}

}  // namespace gw::study

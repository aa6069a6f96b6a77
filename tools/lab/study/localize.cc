// Study "localize": is the place found in a saved map, from a start anywhere and after the robot
// was carried? trials.h says what is tried and what counts.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <list>
#include <memory>
#include <utility>

#include "backend/journal/load.h"
#include "backend/journal/map_session.h"
#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/data/fault/fault_injector.h"
#include "tools/lab/eval/evaluate.h"
#include "tools/lab/measure/measures.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/study.h"
#include "tools/lab/study/trials.h"

namespace gw::study {
namespace {

struct SavedMap {
  backend::Map map;
  SE3 T_GW;  // its keyframes on the truth of the mapping drive
  MappedViews views;
  double ape_m = 0;  // of its keyframes
};

std::optional<SE3> TruthAt(const eval::Trajectory& truth, Utime utime) {
  const eval::EvalOptions gaps;
  const auto pairs = eval::Associate(truth, {{utime, SE3()}}, gaps.max_gap, gaps.max_diff);
  if (pairs.empty()) return std::nullopt;
  return pairs.front().T_ref;
}

// The map that the drive makes, or the one in the folder that gw-slam made of it before.
Result<backend::Map> MakeMap(const Experiment& mapping, const RectifiedCamera& camera,
                             const std::string& folder) {
  if (!folder.empty()) {
    const auto own = backend::MakeSession({}, camera, mapping.config.frontend.orb);
    auto loaded = backend::LoadMapFor(folder, own.source);
    if (!loaded) return loaded.error();
    return std::move(loaded->map);
  }
  const auto session = RunSession(mapping, mapping.config, {});
  if (!session) return session.error();
  return session->mapper().map();
}

Result<SavedMap> MakeSavedMap(const Experiment& mapping, const std::string& folder) {
  const auto geometry = MakeCameraGeometry(mapping.config.calibration);
  if (!geometry) return geometry.error();
  auto map = MakeMap(mapping, geometry->rectified, folder);
  if (!map) return map.error();
  const auto evaluation =
      eval::Evaluate(mapping.truth, KeyframePoses(*map, geometry->rectified), eval::EvalOptions());
  if (!evaluation) {
    return Error{evaluation.error().code,
                 "keyframes of the map of " + mapping.path + ": " + evaluation.error().message};
  }
  std::vector<SE3> views;
  for (const eval::PosePair& pair : evaluation->pairs) views.push_back(pair.T_ref);
  return SavedMap{*std::move(map), evaluation->T_RefEst, MappedViews(std::move(views)),
                  evaluation->ape_translation_m.rmse};
}

// One trial while it runs.
class Runner {
 public:
  static Result<std::unique_ptr<Runner>> Create(const Experiment& drive, const SavedMap& saved,
                                                backend::MapUse use, const Trial& trial) {
    auto session = tools::SlamSession::Create(drive.config, {saved.map, {}, use});
    if (!session) return session.error();
    return std::unique_ptr<Runner>(new Runner(drive, saved, trial, *std::move(session)));
  }

  Result<Done> Process(const process::LogEvent& event) {
    if (!carried_ && trial_.carry) {
      // The injector counts from its first event.
      fault::FaultPlan plan;
      plan.teleport = {{trial_.carry->from - event.received, trial_.carry->to - event.received}};
      carried_.emplace(plan,
                       [this](Utime received, std::string_view channel,
                              const wire::Bytes& message) -> Result<Done> {
                         const bool behind = received >= trial_.carry->from;
                         See({0, received, channel, message},
                             behind ? trial_.carry->to - trial_.carry->from : DurationUs{});
                         return Done{};
                       });
    }
    if (carried_) return carried_->Add(event);
    See(event, {});
    return Done{};
  }

  bool Over(Utime now) const { return now >= trial_.end || judge_.Over(now); }
  const TrialOutcome& outcome() const { return judge_.outcome(); }

 private:
  Runner(const Experiment& drive, const SavedMap& saved, const Trial& trial,
         tools::SlamSession session)
      : drive_(drive), saved_(saved), trial_(trial), session_(std::move(session)), judge_(trial) {}

  // shift: of the log's times against those of the event.
  void See(const process::LogEvent& event, DurationUs shift) {
    const size_t before = session_.frames().size();
    session_.Process(event);
    if (session_.frames().size() == before) return;
    const FramePose& frame = session_.frames().back();
    const Utime at = frame.utime + shift;
    const auto T_GB_true = TruthAt(drive_.truth, at);
    if (!T_GB_true) return;
    judge_.See(at, frame, saved_.T_GW * frame.T_WB, *T_GB_true, saved_.views.InSight(*T_GB_true));
  }

  const Experiment& drive_;
  const SavedMap& saved_;
  Trial trial_;
  tools::SlamSession session_;
  TrialJudge judge_;
  std::optional<fault::FaultInjector> carried_;
};

struct JudgedTrial {
  Trial trial;
  TrialOutcome outcome;
};

// All trials in one reading of the log; results in the order of the trials.
Result<std::vector<JudgedTrial>> RunTrials(const Experiment& drive, const SavedMap& saved,
                                           backend::MapUse use, const std::vector<Trial>& trials) {
  std::vector<JudgedTrial> out(trials.size());
  for (size_t i = 0; i < trials.size(); ++i) out[i].trial = trials[i];
  auto log = process::EventLogReader::Open(drive.path);
  if (!log) return log.error();
  std::list<std::pair<size_t, std::unique_ptr<Runner>>> running;
  size_t next = 0, ended = 0;
  const auto end = [&](size_t index, const Runner& runner) {
    out[index].outcome = runner.outcome();
    ++ended;
  };
  while (ended < trials.size()) {
    const auto event = log->Next();
    if (!event) break;
    for (; next < trials.size() && trials[next].begin <= event->received; ++next) {
      auto runner = Runner::Create(drive, saved, use, trials[next]);
      if (!runner) return runner.error();
      running.emplace_back(next, *std::move(runner));
    }
    for (auto it = running.begin(); it != running.end();) {
      const auto done = it->second->Process(*event);
      if (!done) return done.error();
      if (!it->second->Over(event->received)) {
        ++it;
        continue;
      }
      end(it->first, *it->second);
      it = running.erase(it);
      std::fprintf(stderr, "gw-study: %zu of %zu trials\n", ended, trials.size());
    }
  }
  if (log->error()) return *log->error();
  for (const auto& [index, runner] : running) end(index, *runner);
  return out;
}

// The four kinds of trials.
struct Group {
  const char* name;
  bool carried, mapped;
  bool Holds(const Trial& trial) const {
    return trial.carry.has_value() == carried && trial.mapped == mapped;
  }
};
constexpr Group kGroups[] = {
    {"start, a mapped view in sight", false, true},
    {"start, none in sight", false, false},
    {"carried to a mapped view", true, true},
    {"carried to where none is in sight", true, false},
};

struct GroupResult {
  int64_t trials = 0, knew = 0, view = 0, localised = 0, with_wrong = 0, wrong_images = 0;
  double worst_claim_m = 0, worst_error_m = 0;
  std::vector<double> delays_s;  // sorted
};

GroupResult Summarise(const Group& group, const std::vector<JudgedTrial>& trials) {
  GroupResult r;
  for (const auto& [trial, outcome] : trials) {
    if (!group.Holds(trial)) continue;
    ++r.trials;
    r.knew += outcome.knew ? 1 : 0;
    r.view += outcome.view ? 1 : 0;
    r.with_wrong += outcome.wrong > 0 ? 1 : 0;
    r.wrong_images += outcome.wrong;
    r.worst_claim_m = std::max(r.worst_claim_m, outcome.worst_claim_m);
    if (!outcome.localised) continue;
    ++r.localised;
    r.worst_error_m = std::max(r.worst_error_m, outcome.error_m);
    r.delays_s.push_back(outcome.Delay()->seconds());
  }
  std::sort(r.delays_s.begin(), r.delays_s.end());
  return r;
}

std::string SecondsText(const std::optional<DurationUs>& duration) {
  return duration ? FormatFixed(duration->seconds(), 2) : "";
}

class LocalizeStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("map_log", map_log_, "LCM event log with ground truth: the drive that maps")
        ->Required();
    app.AddOption("log", log_,
                  "another drive in the same building, its ground truth in the same frame")
        ->Required();
    app.AddOption("--config", config_, "robot YAML of both")->Required();
    app.AddOption("--map", map_,
                  "folder that gw-slam --map-out made of map_log, in place of making the map")
        ->ExistingFolder();
    app.AddOption("--starts", plan_.starts,
                  "starts with a mapped view in sight, and as many with none (50)")
        ->InRange(0, 10000);
    app.AddOption("--carries", plan_.carries,
                  "times that the robot is carried to a mapped view, and as many to none (20)")
        ->InRange(0, 10000);
    app.AddOption("--seconds", seconds_, "that a trial lasts when the place is not found (20)")
        ->InRange(10.0, 600.0);
    app.AddOption("--seed", plan_.seed, "of the draws (1)");
    app.AddFlag("--localize-only", localize_only_,
                "the map stays as it is; otherwise it grows in each trial, from the same begin");
  }

  Result<StudyFiles> Run() override {
    auto mapping = LoadExperiment(map_log_, config_);
    if (!mapping) return mapping.error();
    auto drive = LoadExperiment(log_, config_);
    if (!drive) return drive.error();
    const auto saved = MakeSavedMap(*mapping, map_);
    if (!saved) return saved.error();
    std::fprintf(stderr, "gw-study: map of %zu keyframes, APE %.4f m\n",
                 saved->map.keyframes().size(), saved->ape_m);
    plan_.length = DurationFromSeconds(seconds_);
    const auto use = localize_only_ ? backend::MapUse::kFrozen : backend::MapUse::kGrow;
    const auto trials =
        RunTrials(*drive, *saved, use, DrawTrials(drive->truth, saved->views, plan_));
    if (!trials) return trials.error();
    const std::string origin = "map: " + Describe(*mapping) + "; " + Describe(*drive) + "; seed " +
                               std::to_string(plan_.seed) + ", configuration " +
                               ConfigHashText(drive->config) + ", gw-study " + Version() +
                               (localize_only_ ? ", localize only" : ", the map grows");
    return Render(*saved, origin, *trials);
  }

 private:
  static StudyFiles Render(const SavedMap& saved, const std::string& origin,
                           const std::vector<JudgedTrial>& trials) {
    StudyFiles files;
    files.markdown =
        "# Localisation in a saved map\n\n" + origin +
        ". Map: " + std::to_string(saved.map.keyframes().size()) + " keyframes, APE " +
        FormatFixed(saved.ape_m, 4) +
        " m.\n\nA mapped view: within 1 m and 30 deg of a keyframe. Localised: vision carries the "
        "pose, its sigma is below 0.1 m, and it is within 0.3 m and 5 deg of the truth. Delay: "
        "from the first mapped view in sight, s. Wrong: sigma below 0.1 m, and more than 0.5 m "
        "off.\n\n"
        "| trials | number | knew its place before | saw a mapped view | localised | delay, median "
        "| 90 % | longest | largest error then, m | trials (images) wrong | worst claim, m |\n| "
        "--- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
    plot::Panel panel;
    panel.title = "localised within a time";
    panel.x_label = "s since the first mapped view in sight";
    panel.y_label = "share of the trials that saw one";
    panel.y_range = {0, 1.05};
    for (const Group& group : kGroups) {
      const GroupResult r = Summarise(group, trials);
      if (r.trials == 0) continue;
      const auto delay = [&](double q) {
        if (r.delays_s.empty()) return std::string("-");
        const auto last = static_cast<double>(r.delays_s.size() - 1);
        return FormatFixed(r.delays_s[static_cast<size_t>(std::lround(q * last))], 2);
      };
      files.markdown += std::string("| ") + group.name + " | " + std::to_string(r.trials) + " | " +
                        (group.carried ? std::to_string(r.knew) : "-") + " | " +
                        std::to_string(r.view) + " | " + std::to_string(r.localised) + " | " +
                        (r.delays_s.empty() ? "-" : FormatFixed(measure::Median(r.delays_s), 2)) +
                        " | " + delay(0.9) + " | " + delay(1) + " | " +
                        FormatFixed(r.worst_error_m, 3) + " | " + std::to_string(r.with_wrong) +
                        " (" + std::to_string(r.wrong_images) + ") | " +
                        FormatFixed(r.worst_claim_m, 3) + " |\n";
      plot::Series series;
      series.label = group.name;
      for (size_t i = 0; i < r.delays_s.size(); ++i) {
        series.x.push_back(r.delays_s[i]);
        series.y.push_back(static_cast<double>(i + 1) / static_cast<double>(r.view));
      }
      if (!series.x.empty()) panel.series.push_back(std::move(series));
    }
    files.csv =
        "begin_us,carried_from_us,carried_to_us,mapped,knew,view_s,localised_s,error_m,error_deg,"
        "images,wrong,worst_claim_m\n";
    for (const auto& [trial, outcome] : trials) {
      files.csv += std::to_string(trial.begin.us) + "," +
                   (trial.carry ? std::to_string(trial.carry->from.us) : "") + "," +
                   (trial.carry ? std::to_string(trial.carry->to.us) : "") + "," +
                   std::to_string(int{trial.mapped}) + "," + std::to_string(int{outcome.knew}) +
                   "," + SecondsText(outcome.view) + "," + SecondsText(outcome.localised) + "," +
                   FormatFixed(outcome.error_m, 4) + "," + FormatFixed(outcome.error_deg, 3) + "," +
                   std::to_string(outcome.images) + "," + std::to_string(outcome.wrong) + "," +
                   FormatFixed(outcome.worst_claim_m, 4) + "\n";
    }
    plot::Figure figure;
    figure.title = "Localisation in a saved map";
    figure.panels = {panel};
    figure.footer = {origin};
    files.drawing = plot::Draw(figure);
    return files;
  }

  std::string map_log_, log_, config_, map_;
  TrialPlan plan_;
  double seconds_ = 20;
  bool localize_only_ = false;
};

}  // namespace

std::unique_ptr<Study> MakeLocalizeStudy() {
  return std::make_unique<LocalizeStudy>();
}

}  // namespace gw::study

// Study "loops": does the map close every loop of the drive, join no two places, and does a closure
// make it better? revisits.h says what counts.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/eval/evaluate.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/revisits.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

std::string Joined(std::initializer_list<std::string> cells, const char* separator) {
  std::string out;
  for (const std::string& cell : cells) {
    if (!out.empty()) out += separator;
    out += cell;
  }
  return out;
}

void AddLine(std::initializer_list<std::string> cells, StudyFiles* files) {
  files->markdown += "| ";
  files->markdown += Joined(cells, " | ");
  files->markdown += " |\n";
}

// The map around the moment in which a loop was closed.
struct Closure {
  Utime utime;                            // of the newest keyframe
  eval::Trajectory before;                // its keyframes
  eval::Trajectory after_graph;           // the pose graph moved them,
  std::optional<eval::Trajectory> after;  // and global BA
};

// Sees the session after every event.
class ClosureWatch {
 public:
  void Observe(const tools::SlamSession& session) {
    const backend::Mapper& mapper = session.mapper();
    if (mapper.map().revision() == revision_) return;
    revision_ = mapper.map().revision();
    eval::Trajectory now = KeyframePoses(mapper.map(), session.camera());
    if (mapper.loop_counters().closed > closed_) {
      closed_ = mapper.loop_counters().closed;
      closures_.push_back({now.back().utime, last_, now, {}});
    }
    if (mapper.counters().global_ba_applied > refined_ && !closures_.empty()) {
      refined_ = mapper.counters().global_ba_applied;
      closures_.back().after = now;
    }
    last_ = std::move(now);
  }
  const std::vector<Closure>& closures() const { return closures_; }

 private:
  int64_t revision_ = 0, closed_ = 0, refined_ = 0;
  eval::Trajectory last_;
  std::vector<Closure> closures_;
};

struct ClosureResult {
  Utime utime;
  double before_m = 0, after_graph_m = 0, after_m = 0;  // APE of the keyframes; NaN: there is none
};

struct LoopsResult {
  Utime begin;  // of the first image
  std::vector<RevisitOutcome> revisits;
  std::vector<ClosureResult> closures;
  int64_t pairs = 0, false_pairs = 0;
  backend::LoopCounters counters;
  double frame_rmse_m = 0;
};

class LoopsStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("log", log_, "LCM event log with ground truth")->Required();
    app.AddOption("--config", config_, "robot YAML")->Required();
    app.AddOption("--seed", seed_, "start that many times 0.1 s later (0)")->InRange(0, 1000);
    app.AddOption("--variant", variant_, "as in gw-slam (full)");
  }

  Result<StudyFiles> Run() override {
    auto experiment = LoadExperiment(log_, config_);
    if (!experiment) return experiment.error();
    const auto config = ConfigFor(*experiment, variant_);
    if (!config) return config.error();
    ClosureWatch watch;
    const auto session =
        RunSession(*experiment, *config, {.seed = seed_, .span = {}},
                   [&](const tools::SlamSession& running) { watch.Observe(running); });
    if (!session) return session.error();
    watch.Observe(*session);  // what was still running when the log ended
    experiment->dr_synthetic = session->dr_synthetic();
    const auto result = Judge(*experiment, *session, watch.closures());
    if (!result) return result.error();
    return Render(*experiment, *config, *result);
  }

 private:
  static Result<LoopsResult> Judge(const Experiment& experiment, const tools::SlamSession& session,
                                   const std::vector<Closure>& closures) {
    LoopsResult out;
    out.counters = session.mapper().loop_counters();
    out.begin = session.frames().front().utime;
    const auto of_frames = eval::Evaluate(experiment.truth, measure::RunOf(session).Live(), {});
    if (!of_frames) return of_frames.error();
    out.frame_rmse_m = of_frames->ape_translation_m.rmse;

    const auto pairs = CovisiblePairs(experiment, session);
    out.pairs = static_cast<int64_t>(pairs.size());
    out.false_pairs = CountFalsePairs(pairs);
    out.revisits = JudgeRevisits(FindRevisits(experiment.truth), pairs);
    const auto ape = [&](const std::optional<eval::Trajectory>& keyframes) {
      if (!keyframes) return std::nan("");
      const auto e = eval::Evaluate(experiment.truth, *keyframes, {});
      return e ? e->ape_translation_m.rmse : std::nan("");
    };
    for (const Closure& c : closures) {
      out.closures.push_back({c.utime, ape(c.before), ape(c.after_graph), ape(c.after)});
    }
    return out;
  }

  static std::vector<CovisiblePair> CovisiblePairs(const Experiment& experiment,
                                                   const tools::SlamSession& session) {
    const backend::Map& map = session.mapper().map();
    const eval::EvalOptions gaps;
    std::map<Utime, SE3> truth;
    for (const eval::PosePair& pair : eval::Associate(
             experiment.truth, KeyframePoses(map, session.camera()), gaps.max_gap, gaps.max_diff)) {
      truth[pair.utime] = pair.T_ref;
    }
    std::vector<CovisiblePair> out;
    for (const auto& [id, keyframe] : map.keyframes()) {
      const auto here = truth.find(keyframe.frame.utime);
      if (here == truth.end()) continue;
      for (const auto& [other, shared] :
           map.Neighbours(id, experiment.config.backend.covisibility_min_shared)) {
        const auto there = truth.find(map.FindKeyframe(other)->frame.utime);
        if (there == truth.end() || there->first > here->first) continue;
        out.push_back({there->first, here->first,
                       (there->second.translation() - here->second.translation()).norm()});
      }
    }
    return out;
  }

  StudyFiles Render(const Experiment& experiment, const RobotConfig& config,
                    const LoopsResult& r) const {
    const std::string origin = Describe(experiment) + ", " + variant_ + ", seed " +
                               std::to_string(seed_) + ", gw-study " + Version() +
                               ", configuration " + ConfigHashText(config);
    const auto closed = std::count_if(r.revisits.begin(), r.revisits.end(),
                                      [](const RevisitOutcome& o) { return o.pairs > 0; });
    StudyFiles files;
    files.markdown =
        "# Loops\n\n" + origin + ".\n\nLoops of the drive closed: " + std::to_string(closed) +
        " of " + std::to_string(r.revisits.size()) + "; covisible pairs of keyframes " +
        std::to_string(r.pairs) + ", false ones (" + FormatFixed(kFalseDistance, 0) +
        " m apart or more) " + std::to_string(r.false_pairs) + ". APE of the poses as published " +
        FormatFixed(r.frame_rmse_m, 4) + " m. Candidates " + std::to_string(r.counters.candidates) +
        ", fits " + std::to_string(r.counters.fits) + ", inconsistent " +
        std::to_string(r.counters.inconsistent) + ", refused by dead reckoning " +
        std::to_string(r.counters.refused_by_dr) + ", closed by the loop closer " +
        std::to_string(r.counters.closed) + ", removed " + std::to_string(r.counters.removed) +
        ".\n\n| back where it was, s | pairs that join it to before | first after, s "
        "|\n| --- | --- | --- |\n";
    files.csv = "what,begin_s,end_s,pairs,delay_s,ape_before_m,ape_after_graph_m,ape_after_m\n";
    for (const RevisitOutcome& o : r.revisits) {
      const std::string begin = FormatFixed((o.revisit.begin - r.begin).seconds(), 1);
      const std::string end = FormatFixed((o.revisit.end - r.begin).seconds(), 1);
      const std::string delay = o.delay ? FormatFixed(o.delay->seconds(), 2) : "";
      const std::string pairs = std::to_string(o.pairs);
      AddLine({Joined({begin, end}, " - "), pairs, o.delay ? delay : "never"}, &files);
      files.csv += Joined({"revisit", begin, end, pairs, delay, ",,\n"}, ",");
    }
    files.markdown +=
        "\n| loop closed, s | APE of the keyframes before, m | after the pose graph | after global "
        "BA | after / before |\n| --- | --- | --- | --- | --- |\n";
    for (const ClosureResult& c : r.closures) {
      const std::string t = FormatFixed((c.utime - r.begin).seconds(), 1);
      const std::string before = FormatFixed(c.before_m, 4);
      const std::string after_graph = FormatFixed(c.after_graph_m, 4);
      const std::string after = FormatFixed(c.after_m, 4);
      AddLine({t, before, after_graph, after, FormatFixed(c.after_m / c.before_m, 2)}, &files);
      files.csv += Joined({"closure", t, ",,", before, after_graph, after}, ",");
      files.csv += "\n";
    }
    files.drawing = Plot(experiment, r, origin);
    return files;
  }

  // The way from above; where it leads along itself again, and what of that is joined.
  static plot::Drawing Plot(const Experiment& experiment, const LoopsResult& r,
                            const std::string& origin) {
    plot::Panel way;
    way.title = "the drive, and where it comes back";
    way.x_label = "x, m";
    way.y_label = "y, m";
    way.equal_aspect = true;
    plot::Series all, joined, open;
    all.label = "way";
    all.color = "#bbbbbb";
    joined.label = "again, joined to before";
    joined.color = "#2ca02c";
    joined.width = 3;
    open.label = "again, not joined";
    open.color = "#d62728";
    open.width = 3;
    for (const eval::TimedPose& pose : experiment.truth) {
      const double x = pose.T.translation().x();
      const double y = pose.T.translation().y();
      all.x.push_back(x);
      all.y.push_back(y);
      const auto in =
          std::find_if(r.revisits.begin(), r.revisits.end(), [&](const RevisitOutcome& o) {
            return pose.utime >= o.revisit.begin && pose.utime <= o.revisit.end;
          });
      for (plot::Series* series : {&joined, &open}) {
        const bool here = in != r.revisits.end() && (in->pairs > 0) == (series == &joined);
        series->x.push_back(x);
        series->y.push_back(here ? y : std::nan(""));
      }
    }
    way.series = {all, joined, open};
    plot::Figure figure;
    figure.title = "Loops";
    figure.panels = {way};
    figure.footer = {origin};
    return plot::Draw(figure);
  }

  std::string log_, config_, variant_ = "full";
  int seed_ = 0;
};

}  // namespace

std::unique_ptr<Study> MakeLoopsStudy() {
  return std::make_unique<LoopsStudy>();
}

}  // namespace gw::study

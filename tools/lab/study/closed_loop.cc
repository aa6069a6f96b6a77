// Study "closed-loop" (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, figure tsrb_cl): a
// simulated robot drives several ways on the poses of the whole system, all processes live, in real
// time. Per trial the error of the poses, the latency from image to pose, and a picture of the way
// with the map's landmarks.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "backend/journal/load.h"
#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/bench_suite/programs.h"
#include "tools/lab/eval/evaluate.h"
#include "tools/lab/measure/measures.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

namespace fs = std::filesystem;

struct Trial {
  std::string name;  // of its way
  eval::Evaluation evaluation;
  double latency_ms = 0;                   // median, from the image to the pose
  std::vector<Eigen::Vector3d> landmarks;  // in the frame of the truth
  eval::Trajectory truth, estimate;        // the estimate in the frame of the truth
};

// Column `latency_us` of what gw-monitor and gw-report note, of images with a pose in time.
Result<std::vector<double>> ReadLatencies(const std::string& path) {
  const auto text = tools::ReadTextFile(path);
  if (!text) return text.error();
  std::istringstream lines(*text);
  std::string line;
  std::getline(lines, line);
  if (!line.ends_with(",latency_us")) {
    return Error{ErrorCode::kBadData, path + ": the last column must be latency_us"};
  }
  std::vector<double> out;
  while (std::getline(lines, line)) {
    const double ms = 1e-3 * std::strtod(line.substr(line.rfind(',') + 1).c_str(), nullptr);
    if (ms > 0) out.push_back(ms);
  }
  if (out.empty()) return Error{ErrorCode::kBadData, path + ": no image has a pose"};
  return out;
}

Result<Trial> ReadTrial(const std::string& name, const std::string& folder) {
  Trial trial;
  trial.name = name;
  auto truth = eval::ReadTum(folder + "/ground_truth.tum");
  if (!truth) return truth.error();
  auto estimate = eval::ReadTum(folder + "/trajectory.tum");
  if (!estimate) return estimate.error();
  eval::EvalOptions options;
  options.alignment = eval::Alignment::kYaw;
  auto evaluation = eval::Evaluate(*truth, *estimate, options);
  if (!evaluation)
    return Error{evaluation.error().code, folder + ": " + evaluation.error().message};
  const auto latencies = ReadLatencies(folder + "/frames.csv");
  if (!latencies) return latencies.error();
  const auto map = backend::LoadMap(folder + "/map");
  if (!map) return map.error();
  trial.evaluation = *std::move(evaluation);
  trial.latency_ms = measure::Median(*latencies);
  for (const LandmarkId id : map->map.SortedLandmarkIds()) {
    trial.landmarks.push_back(trial.evaluation.T_RefEst * map->map.FindLandmark(id)->p_W);
  }
  trial.truth = *std::move(truth);
  for (const eval::TimedPose& pose : *estimate) {
    trial.estimate.push_back({pose.utime, trial.evaluation.T_RefEst * pose.T});
  }
  return trial;
}

plot::Series Way(const std::string& label, const eval::Trajectory& trajectory) {
  plot::Series series;
  series.label = label;
  for (size_t i = 0; i < trajectory.size(); i += 5) {
    series.x.push_back(trajectory[i].T.translation().x());
    series.y.push_back(trajectory[i].T.translation().y());
  }
  return series;
}

// As the paper's last figure: what the map knows, where the robot was, where it believed to be.
plot::Panel Picture(const Trial& trial) {
  plot::Panel panel;
  panel.title = trial.name + ": RMSE " + FormatFixed(trial.evaluation.ape_translation_m.rmse, 3) +
                " m, latency " + FormatFixed(trial.latency_ms, 1) + " ms";
  panel.x_label = "x, m";
  panel.y_label = "y, m";
  panel.equal_aspect = true;
  plot::Series landmarks;
  landmarks.label = "landmarks";
  landmarks.style = plot::Style::kPoints;
  landmarks.color = "#c0c0c0";
  for (const Eigen::Vector3d& p : trial.landmarks) {
    landmarks.x.push_back(p.x());
    landmarks.y.push_back(p.y());
  }
  panel.series = {landmarks, Way("true", trial.truth), Way("estimated", trial.estimate)};
  panel.series.back().dashed = true;
  return panel;
}

StudyFiles Render(const std::vector<Trial>& trials, const std::string& scenario) {
  StudyFiles files;
  files.markdown = "# Closed loop\n\nscenario " + scenario + ", gw-study " + Version() +
                   "; all processes live, driven on their own poses; RMSE of the poses as "
                   "published, aligned by yaw\nand shift; latency from the image to its pose.\n\n"
                   "| way | length, m | images | RMSE, m | latency, median, ms | landmarks |\n"
                   "| --- | --- | --- | --- | --- | --- |\n";
  files.csv = "way,length_m,poses,rmse_m,latency_median_ms,landmarks\n";
  plot::Figure figure;
  figure.title = "Closed loop";
  figure.columns = 3;
  figure.panel_width = 480;
  figure.panel_height = 420;
  for (const Trial& trial : trials) {
    const eval::Evaluation& e = trial.evaluation;
    const std::vector<std::string> cells = {trial.name,
                                            FormatFixed(e.drift.path_length_m, 1),
                                            std::to_string(e.num_est),
                                            FormatFixed(e.ape_translation_m.rmse, 4),
                                            FormatFixed(trial.latency_ms, 2),
                                            std::to_string(trial.landmarks.size())};
    for (size_t i = 0; i < cells.size(); ++i) {
      files.markdown += (i == 0 ? "| " : " | ") + cells[i];
      files.csv += (i == 0 ? "" : ",") + cells[i];
    }
    files.markdown += " |\n";
    files.csv += "\n";
    figure.panels.push_back(Picture(trial));
  }
  figure.footer = {"scenario " + scenario + ", gw-study " + Version()};
  files.drawing = plot::Draw(figure);
  return files;
}

class ClosedLoopStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("ways", ways_, "files of waypoint indices, one drive each (gw-navigate --path)")
        ->Required();
    app.AddOption("--scenario", scenario_, "of gw-sim")->Required();
    app.AddOption("--map", map_, "floor map: map.yaml")->Required();
    app.AddOption("--waypoints", waypoints_, "its waypoints")->Required();
    app.AddOption("--trials", trials_,
                  "folder of the drives' records; one that is there is not driven again")
        ->Required();
    app.AddOption("--demo", demo_, "the script that starts the processes")->ShowDefault();
  }

  Result<StudyFiles> Run() override {
    std::vector<Trial> trials;
    for (const std::string& way : ways_) {
      const std::string name = fs::path(way).stem().string();
      const std::string folder = trials_ + "/" + name;
      if (!fs::exists(folder + "/ground_truth.tum")) {
        const auto driven = Drive(way, folder);
        if (!driven) return driven.error();
      }
      auto trial = ReadTrial(name, folder);
      if (!trial) return trial.error();
      trials.push_back(*std::move(trial));
    }
    return Render(trials, fs::path(scenario_).stem().string());
  }

 private:
  // In real time: no other program should need the machine.
  Result<Done> Drive(const std::string& way, const std::string& folder) const {
    if (!fs::exists(demo_)) {
      return Error{ErrorCode::kNotFound, demo_ +
                                             ": not there; start from the repository, or "
                                             "name it with --demo"};
    }
    const auto self = bench::SiblingProgram("gw-study");
    if (!self) return self.error();
    std::error_code error;
    fs::create_directories(trials_, error);
    std::fprintf(stderr, "gw-study: drives %s\n", way.c_str());
    return bench::RunProgram({"/usr/bin/env", "python3", demo_, "--scenario", scenario_, "--map",
                              map_, "--waypoints", waypoints_, "--path", way, "--out", folder,
                              "--view-port", "0", "--bin", fs::path(*self).parent_path().string()},
                             folder + ".txt");
  }

  std::vector<std::string> ways_;
  std::string scenario_, map_, waypoints_, trials_;
  std::string demo_ = "tools/sim/demo/demo";
};

}  // namespace

std::unique_ptr<Study> MakeClosedLoopStudy() {
  return std::make_unique<ClosedLoopStudy>();
}

}  // namespace gw::study

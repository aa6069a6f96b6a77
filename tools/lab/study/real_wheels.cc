// Study "real-wheels": the odometry of real robots under a rendered camera that drives their way,
// with the lights out and bare walls at times. Raw wheels, vision alone and both.
#include "tools/lab/study/real_wheels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "common/core/format.h"
#include "common/core/version.h"
#include "tools/lab/bench_suite/programs.h"
#include "tools/lab/study/fault_run.h"
#include "tools/lab/study/study.h"

namespace gw::study {
namespace {

namespace fs = std::filesystem;

constexpr double kBestBar = 1.05, kWheelsBar = 0.5;

struct Recording {
  std::string name, truth, odometry;
};

// A folder with the files of OpenLORIS or of the CARMEN recordings.
Result<Recording> FindRecording(const std::string& folder) {
  const fs::path path(folder);
  const std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  constexpr std::pair<const char*, const char*> kNames[] = {{"groundtruth.txt", "odom.txt"},
                                                            {"laser_pose.txt", "odom_raw.txt"}};
  for (const auto& [truth, odometry] : kNames) {
    if (fs::exists(path / truth) && fs::exists(path / odometry)) {
      return Recording{name, path / truth, path / odometry};
    }
  }
  return Error{ErrorCode::kNotFound,
               folder + ": want groundtruth.txt and odom.txt, or laser_pose.txt and odom_raw.txt"};
}

// Renders the camera along the way into a log and writes the robot's configuration beside it.
Result<Done> Render(const Recording& recording, const std::string& scenario,
                    const std::string& base) {
  const auto program = bench::SiblingProgram("gw-sim");
  if (!program) return program.error();
  std::fprintf(stderr, "gw-study: rendering %s.lcm\n", base.c_str());
  return bench::RunProgram(
      {*program, "--scenario", scenario, "--trajectory", recording.truth, "--odometry",
       recording.odometry, "--log", base + ".lcm", "--config-out", base + ".yaml"},
      base + ".out");
}

double WayOf(const eval::Trajectory& truth) {
  double way = 0;
  for (size_t i = 1; i < truth.size(); ++i) {
    way += (truth[i].T.translation() - truth[i - 1].T.translation()).norm();
  }
  return way;
}

std::string SaidBy(const Findings& findings) {
  std::string out;
  for (const auto& [name, finding] : findings) {
    out.append(out.empty() ? "" : ", ").append(name).append(" ");
    out.append(std::to_string(finding.count));
  }
  return out;
}

std::string Number(const std::optional<double>& value, int decimals) {
  return value ? FormatFixed(*value, decimals) : "-";
}

class RealWheelsStudy : public Study {
 public:
  void AddOptions(cli::Command& app) override {
    app.AddOption("recordings", folders_,
                  "folders with the way of a robot and its odometry: groundtruth.txt and odom.txt "
                  "(OpenLORIS), or laser_pose.txt and odom_raw.txt (CARMEN)")
        ->Required();
    app.AddOption(
           "--scenario", scenario_,
           "of gw-sim: camera, walls, what is hard on the way (config/scenarios/real_wheels.yaml)")
        ->Required();
    app.AddOption("--logs", logs_, "folder for the logs; what is there is used again")->Required();
    app.AddOption("--seed", seed_, "start of the runs (0)")->InRange(0, 100);
  }

  Result<StudyFiles> Run() override {
    std::error_code error;
    fs::create_directories(logs_, error);
    if (error) return Error{ErrorCode::kIo, logs_ + ": cannot be made: " + error.message()};
    std::vector<RealWheelsRow> rows;
    for (const std::string& folder : folders_) {
      const auto recording = FindRecording(folder);
      if (!recording) return recording.error();
      auto row = RunRecording(*recording);
      if (!row) return row.error();
      std::fprintf(stderr, "gw-study: %s: wheels %s, none %s, full %s m\n", row->name.c_str(),
                   Number(row->wheels_m, 3).c_str(), Number(row->none.ape_m, 3).c_str(),
                   Number(row->full.ape_m, 3).c_str());
      rows.push_back(*std::move(row));
    }
    return RenderRealWheels("Scenario " + fs::path(scenario_).filename().string() + ", start " +
                                std::to_string(seed_) + ", gw-study " + Version(),
                            rows);
  }

 private:
  Result<RealWheelsRow> RunRecording(const Recording& recording) const {
    const std::string base = (fs::path(logs_) / recording.name).string();
    if (!fs::exists(base + ".lcm")) {
      const auto rendered = Render(recording, scenario_, base);
      if (!rendered) return rendered.error();
    }
    auto experiment = LoadExperiment(base + ".lcm", base + ".yaml");
    if (!experiment) return experiment.error();
    RealWheelsRow row;
    row.name = recording.name;
    row.way_m = WayOf(experiment->truth);
    row.seconds = (experiment->truth.back().utime - experiment->truth.front().utime).seconds();
    const auto dr = ReckonWithFault(*experiment, experiment->config, {});
    if (!dr) return dr.error();
    row.wheels_m = Ape(experiment->truth, dr->wheels, eval::Alignment::kYaw);
    row.dr_m = Ape(experiment->truth, dr->filter, eval::Alignment::kYaw);
    for (const bool full : {false, true}) {
      const auto config = ConfigFor(*experiment, full ? "full" : "none");
      if (!config) return config.error();
      const auto run = RunWithFault(&*experiment, *config, {}, seed_);
      if (!run) return run.error();
      (full ? row.full : row.none) =
          MeasureFault(run->run, SE3(), experiment->truth, eval::Alignment::kYaw);
      if (full) row.said = SaidBy(run->findings);
    }
    return row;
  }

  std::vector<std::string> folders_;
  std::string scenario_, logs_;
  int seed_ = 0;
};

plot::Drawing Bars(const std::string& origin, const std::vector<RealWheelsRow>& rows) {
  plot::BarPanel panel;
  panel.title = "error of the pose over that of the better witness";
  panel.x_label = "APE of `full` / the smaller of wheels and `none`";
  panel.x_max = 3;
  panel.marker = kBestBar;
  panel.marker_label = "bar";
  for (const RealWheelsRow& row : rows) {
    plot::Bar bar;
    bar.label = row.name;
    bar.value = RatiosOf(row).to_best;
    bar.note = Number(row.full.ape_m, 3) + " m";
    bar.hatched = bar.value && *bar.value <= kBestBar;
    panel.bars.push_back(std::move(bar));
  }
  plot::BarFigure figure;
  figure.title = "Real wheels under a rendered camera";
  figure.panel_width = 960;
  figure.panels = {panel};
  figure.footer = {origin, "hatched: the bar is met"};
  return plot::Draw(figure);
}

}  // namespace

RealWheelsRatios RatiosOf(const RealWheelsRow& row) {
  RealWheelsRatios out;
  if (!row.full.ape_m || !row.wheels_m) return out;
  out.to_wheels = *row.full.ape_m / *row.wheels_m;
  out.to_best = *row.full.ape_m / std::min(*row.wheels_m, row.none.ape_m.value_or(INFINITY));
  return out;
}

StudyFiles RenderRealWheels(const std::string& origin, const std::vector<RealWheelsRow>& rows) {
  StudyFiles files;
  files.markdown =
      "# Real wheels under a rendered camera\n\n" + origin +
      ". APE RMSE in m, live poses, aligned by yaw and shift. Bars: `full` at most " +
      FormatFixed(kBestBar, 2) + " x the better of wheels and `none` on each, " +
      FormatFixed(kWheelsBar, 1) +
      " x wheels in the mean of the ratios; a pose for every image. Blind: images that dead "
      "reckoning carried. Too sure: longest span of tracking with an error over 5 sigma since the "
      "begin, s, and the share of such images.\n\n"
      "| run | way | time | wheels | DR alone | `none` | lost | `full` | blind | without pose | "
      "too sure | share | `full` / best | `full` / wheels | bar | said |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
      "| --- |\n";
  files.csv =
      "run,way_m,seconds,wheels_m,dr_m,none_m,none_lost,full_m,blind,without_pose,too_sure_s,"
      "too_sure_share,to_best,to_wheels\n";
  double sum = 0;
  bool determined = true;
  for (const RealWheelsRow& row : rows) {
    const RealWheelsRatios ratios = RatiosOf(row);
    const bool met = ratios.to_best && *ratios.to_best <= kBestBar && row.full.without_pose == 0;
    determined &= ratios.to_wheels.has_value();
    sum += ratios.to_wheels.value_or(0);
    const std::vector<std::string> cells = {row.name,
                                            FormatFixed(row.way_m, 0),
                                            FormatFixed(row.seconds, 0),
                                            Number(row.wheels_m, 3),
                                            Number(row.dr_m, 3),
                                            Number(row.none.ape_m, 3),
                                            std::to_string(row.none.without_pose),
                                            Number(row.full.ape_m, 3),
                                            std::to_string(row.full.blind),
                                            std::to_string(row.full.without_pose),
                                            FormatFixed(row.full.too_sure_s, 1),
                                            FormatFixed(row.full.too_sure_share, 2),
                                            Number(ratios.to_best, 2),
                                            Number(ratios.to_wheels, 2)};
    std::string line = "|", csv;
    for (const std::string& cell : cells) {
      line.append(" ").append(cell).append(" |");
      csv.append(csv.empty() ? "" : ",").append(cell);
    }
    files.markdown += line + (met ? " met | " : " **missed** | ") + row.said + " |\n";
    files.csv += csv + "\n";
  }
  const double mean = sum / static_cast<double>(rows.size());
  files.markdown +=
      "\n`full` / wheels in the mean: " + (determined ? FormatFixed(mean, 2) : std::string("-")) +
      (determined && mean <= kWheelsBar ? ", met" : ", **missed**") + ".\n";
  files.drawing = Bars(origin, rows);
  return files;
}

std::unique_ptr<Study> MakeRealWheelsStudy() {
  return std::make_unique<RealWheelsStudy>();
}

}  // namespace gw::study

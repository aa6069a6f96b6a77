// What the studies share: a log with its robot and its truth, runs over it in this process, and the
// files that a study leaves.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "tools/lab/eval/trajectory.h"
#include "tools/lab/measure/slam_run.h"
#include "tools/lab/plot/drawing.h"
#include "tools/lab/slam/run_log.h"

namespace gw::study {

struct Experiment {
  std::string path;  // of the log
  std::string name;  // of its file
  std::string hash;  // of its bytes
  RobotConfig config;
  eval::Trajectory truth;
  bool dr_synthetic = false;  // known after a run
};

// Error: kNotFound, kIo, kBadConfig; kBadData for a log without ground truth.
Result<Experiment> LoadExperiment(const std::string& log, const std::string& config);

// The experiment's configuration with another variant, which must be one (ApplyVariant).
Result<RobotConfig> ConfigFor(const Experiment& experiment, const std::string& variant);
std::string ConfigHashText(const RobotConfig& config);

// Runs the log and finishes the session. after_event: sees the session after each event.
// Error: as of the stages and of RunLog; kBadData when no image can be used.
Result<tools::SlamSession> RunSession(
    const Experiment& experiment, const RobotConfig& config, const tools::LogRunOptions& options,
    const std::function<void(const tools::SlamSession&)>& after_event = nullptr);

// The same, what it leaves image by image; notes whether dead reckoning is synthetic.
Result<measure::SlamRun> Run(Experiment* experiment, const std::string& variant,
                             const tools::LogRunOptions& options);

// The keyframes of a map as poses of the body.
eval::Trajectory KeyframePoses(const backend::Map& map, const RectifiedCamera& camera);

// "log X (hash ..)": for tables and plots. Says so where dead reckoning is synthetic.
std::string Describe(const Experiment& experiment);

struct StudyFiles {
  std::string markdown, csv;
  plot::Drawing drawing;
};

// FOLDER/NAME.md, .csv, .svg and .html, which is the report of all; the folder is made when
// missing.
Result<Done> WriteStudy(const std::string& folder, const std::string& name,
                        const StudyFiles& files);

}  // namespace gw::study

// What gw-slam leaves behind: trajectories, table and report. File formats: docs/programs.md.
#pragma once

#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "tools/data/files/json_fwd.h"
#include "tools/lab/slam/laps.h"
#include "tools/lab/slam/slam_session.h"

namespace gw::tools {

enum class OutputFrame { kBody, kCamera };

struct RunDescription {
  std::string log_name;  // without its folder, so that reports of one log compare equal
  std::string variant;
  OutputFrame frame = OutputFrame::kBody;
  int seed = 0;  // see run_log.h
  LapsRun laps = {};
};

// Writes trajectory.tum, trajectory_final.tum, keyframes.tum, dr.tum, frames.csv, covariance.csv,
// dr_prior.csv and report.json into `folder` (made when missing); of a run of several laps also
// lapN/trajectory.tum, trajectory_final.tum and keyframes.tum in times of the log. Error kIo: the
// file and what the system says.
Result<Done> WriteOutputs(const std::string& folder, const RobotConfig& config,
                          const RunDescription& run, const SlamSession& session);

// utime and front-end time of each image, as CSV. Differs from run to run, so it is none of the
// outputs above.
std::string TimingTable(const SlamSession& session);

// Where the time of the log goes back or jumps ahead, as a list for report.json.
Json TimeStepsJson(const std::vector<TimeStep>& steps);

}  // namespace gw::tools

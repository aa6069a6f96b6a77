// What gw-slam --dr-only leaves behind, and what it says about it.
#pragma once

#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "tools/lab/slam/dr_motion.h"
#include "tools/lab/slam/dr_only.h"
#include "tools/lab/slam/slam_output.h"

namespace gw::tools {

struct DrRunDescription {
  std::string log_name;  // without its folder, so that reports of one log compare equal
  OutputFrame frame = OutputFrame::kBody;
  int64_t log_skipped_bytes = 0;
  bool log_truncated = false;
};

// The verdict: lines for people, and whether something is wrong.
struct DrVerdict {
  std::vector<std::string> facts;     // "way: ...", "heading: ...", ...
  std::vector<std::string> problems;  // what to look at; empty: sound
};
DrVerdict JudgeDrRun(const DrOnlyRun& run, const DrMotion& motion, const WheelSum& sum,
                     const RobotConfig& config, const DrRunDescription& description);

// The verdict as text.
std::string VerdictText(const DrVerdict& verdict);

// Writes dr.tum, raw_wheels.tum (when there are wheels), dr_covariance.csv and report.json into
// `folder` (made when missing); formats: docs/programs.md. Error kIo: the file and what the system
// says.
Result<Done> WriteDrOutputs(const std::string& folder, const DrOnlyRun& run, const DrMotion& motion,
                            const WheelSum& sum, const RobotConfig& config,
                            const DrRunDescription& description, const DrVerdict& verdict);

}  // namespace gw::tools

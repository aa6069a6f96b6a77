// One run of the system over a log, image by image: from memory, or read back from what gw-slam
// wrote.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/contract/tracking.h"
#include "tools/lab/eval/trajectory.h"
#include "tools/lab/slam/slam_session.h"

namespace gw::measure {

struct SlamRun {
  std::vector<FramePose> frames;  // as published
  // One per frame:
  std::vector<SE3> final_T_WB;            // by the keyframes as they are at the end
  std::vector<std::optional<SE3>> T_OB;   // dead reckoning alone
  std::vector<std::optional<double>> ms;  // front-end time, where it was measured

  eval::Trajectory Live() const;
  eval::Trajectory Final() const;
  eval::Trajectory DeadReckoning() const;
};

// Precondition: session.Finish() was called.
SlamRun RunOf(const tools::SlamSession& session);

// From report.json.
struct RunOrigin {
  std::string config_hash;
  std::string version;
  bool dr_synthetic = false;
};

struct StoredRun {
  SlamRun run;
  RunOrigin origin;
};

// Reads a folder of gw-slam; `timing` is the file of --timing, or empty. Only those fields of
// FramePose are filled that frames.csv and covariance.csv hold. Error: kNotFound, kIo, kBadData
// with file:line.
Result<StoredRun> ReadRun(const std::string& folder, const std::string& timing);

}  // namespace gw::measure

// Trajectories from files.
#pragma once

#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::eval {

struct TimedPose {
  Utime utime;
  SE3 T;  // of the tracked body in the trajectory's own frame
};
using Trajectory = std::vector<TimedPose>;  // times strictly increase

// TUM format: lines `t tx ty tz qx qy qz qw` (s, m, Hamilton quaternion), blank lines and #
// comments anywhere. Refused with file:line: a line without exactly eight finite numbers, a time
// that does not increase, a quaternion whose norm is off by more than 1e-2 (files have few
// decimals; within, it is normalised). A file without poses is an empty trajectory. Times are
// rounded to 1 us.
Result<Trajectory> ParseTum(const std::string& text, const std::string& name);
Result<Trajectory> ReadTum(const std::string& path);

// The GROUND_TRUTH messages of an LCM event log. Refused, with the number of the event: a message
// that cannot be decoded, and a time that does not increase. A log without any is an error too.
Result<Trajectory> ReadGroundTruthLog(const std::string& path);

// A file that ends in .lcm is read as a log, any other as TUM.
Result<Trajectory> ReadReference(const std::string& path);

// The image times of a frames.csv (first column `utime`, us); the header line names the columns.
Result<std::vector<Utime>> ReadFrameTimes(const std::string& path);

}  // namespace gw::eval

// Trajectories in the files of the data sets, and what is made of them: ground truth of the body,
// wheel increments.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/contract/samples.h"
#include "common/core/result.h"
#include "common/core/se3.h"

namespace gw::importer {

struct StampedPose {
  Utime utime;
  SE3 T;
};

// Lines `t_s tx ty tz qx qy qz qw ...` (more columns are ignored), in time order afterwards. Rows
// with nan, or whose quaternion is none, are left out and counted; error kBadData when they are
// more than half.
Result<std::vector<StampedPose>> ReadTumTrajectory(const std::filesystem::path& file,
                                                   const std::string& what,
                                                   std::vector<std::string>& warnings);

// The same for a ground truth. A recording is of use without it, so where more than half of the
// rows are of no use (a tracker that knows no attitude writes 0 0 0 0) the result is empty, and a
// warning says why.
Result<std::vector<StampedPose>> ReadTrueTrajectory(const std::filesystem::path& file,
                                                    const std::string& what,
                                                    std::vector<std::string>& warnings);

// T_GB = T_GS * inv(T_BS) for a ground truth of sensor S.
std::vector<GroundTruth> GroundTruthOfBody(const std::vector<StampedPose>& T_GS, const SE3& T_BS);

// Motion between neighbouring odometry poses, in B at the begin of each interval, planar part.
std::vector<WheelSample> WheelIncrements(const std::vector<StampedPose>& T_OB);

// Pose at an instant inside the trajectory, on the geodesic of the two neighbours. Precondition:
// not empty, times increase, utime within.
SE3 PoseAt(const std::vector<StampedPose>& trajectory, Utime utime);

}  // namespace gw::importer

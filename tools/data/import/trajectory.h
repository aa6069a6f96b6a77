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

// Lines `t_s tx ty tz qx qy qz qw ...` (more columns are ignored), in time order afterwards.
Result<std::vector<StampedPose>> ReadTumTrajectory(const std::filesystem::path& file,
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

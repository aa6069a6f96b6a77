// How the robot moved as vision alone saw it: gw-slam without any dead reckoning.
#pragma once

#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "common/core/result.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::check {

struct VisionPose {
  Utime utime;
  SE3 T_WB;
  bool seen = false;  // by vision (tracking or degraded)
};

struct VisionRun {
  std::vector<VisionPose> poses;  // of every image, expressed by the keyframes as they ended
  int blind = 0;                  // images without a pose from vision, after the first that had one
};

// Error: those of opening the log; kBadConfig.
Result<VisionRun> RunVision(const std::string& log, RobotConfig config);

}  // namespace gw::check

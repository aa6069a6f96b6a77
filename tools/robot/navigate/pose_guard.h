// May the robot drive on the pose it has, and how fast?
//
//   no pose, or stale   stop: older than pose_timeout_ms
//   uncertain           stop: a sigma above its stop_ limit; go on only when both are back below
//                       kResumeShare of it, so that it does not stutter at the limit
//   between the slow_ and stop_ limits the speed falls linearly from all of it to kLeastShare
#pragma once

#include <optional>

#include "common/config/navigate_config.h"
#include "tools/robot/navigate/robot_pose.h"

namespace gw::navigate {

enum class PoseState { kNone, kStale, kUncertain, kGood };
const char* PoseStateName(PoseState state);

class PoseGuard {
 public:
  explicit PoseGuard(const NavigateConfig& config) : config_(config) {}

  struct Verdict {
    PoseState state = PoseState::kNone;
    double speed_share = 0;  // [0, 1], 0 unless state is kGood
  };
  // pose: the newest, empty when there is none. Call at every control step.
  Verdict Judge(const std::optional<RobotPose>& pose, Utime now);

  static constexpr double kResumeShare = 0.8;
  static constexpr double kLeastShare = 0.3;

 private:
  NavigateConfig config_;
  bool uncertain_ = false;
};

}  // namespace gw::navigate

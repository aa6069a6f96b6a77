#include "tools/robot/navigate/pose_guard.h"

#include <algorithm>
#include <numbers>

namespace gw::navigate {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

}  // namespace

const char* PoseStateName(PoseState state) {
  switch (state) {
    case PoseState::kNone:
      return "none";
    case PoseState::kStale:
      return "stale";
    case PoseState::kUncertain:
      return "uncertain";
    case PoseState::kGood:
      return "good";
  }
  return "";
}

PoseGuard::Verdict PoseGuard::Judge(const std::optional<RobotPose>& pose, Utime now) {
  if (!pose) return {};
  if (now - pose->utime > Milliseconds(config_.pose_timeout_ms)) return {PoseState::kStale, 0};
  // The share that is used of the limits at which it stops.
  const double used = std::max(pose->sigma_m / config_.stop_sigma_m,
                               pose->sigma_rad / (config_.stop_sigma_deg * kDeg));
  uncertain_ = used > (uncertain_ ? kResumeShare : 1.0);
  if (uncertain_) return {PoseState::kUncertain, 0};
  const auto share = [](double sigma, double slow, double stop) {
    return 1 - (1 - kLeastShare) * std::clamp((sigma - slow) / (stop - slow), 0.0, 1.0);
  };
  return {PoseState::kGood,
          std::min(share(pose->sigma_m, config_.slow_sigma_m, config_.stop_sigma_m),
                   share(pose->sigma_rad, config_.slow_sigma_deg * kDeg,
                         config_.stop_sigma_deg * kDeg))};
}

}  // namespace gw::navigate

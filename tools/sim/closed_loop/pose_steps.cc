#include "tools/sim/closed_loop/pose_steps.h"

#include <algorithm>
#include <cmath>

namespace gw::sim {
namespace {

SE3 OdometryOf(const Pose& pose) {
  return pose.T_WO.inverse() * pose.T_WB;
}

// What a pose moved beside its dead reckoning, in the body frame.
SE3 StepBeside(const Pose& before, const Pose& now) {
  const SE3 motion = OdometryOf(before).inverse() * OdometryOf(now);
  return motion.inverse() * before.T_WB.inverse() * now.T_WB;
}

PoseSteps::Largest SizeOf(const SE3& T) {
  return {T.translation().norm(), LogSO3(T.rotation()).norm()};
}

void Enlarge(const PoseSteps::Largest& size, PoseSteps::Largest* largest) {
  largest->m = std::max(largest->m, size.m);
  largest->rad = std::max(largest->rad, size.rad);
}

bool Covers(const Pose& published, const Vector6d& e) {
  constexpr double kSigmas = 3;
  for (int i = 0; i < 6; ++i) {
    if (std::abs(e[i]) > kSigmas * std::sqrt(published.cov_T_WB(i, i)) + 1e-9) return false;
  }
  return true;
}

}  // namespace

void PoseSteps::Push(const Pose& composed, const Pose& published, bool stationary) {
  const SE3 left = published.T_WB.inverse() * composed.T_WB;
  Enlarge(SizeOf(left), &outstanding_);
  not_covered_ += Covers(published, left.Log()) ? 0 : 1;
  if (last_composed_) {
    const bool snapped = published.reset_counter != last_published_->reset_counter;
    snaps_ += snapped ? 1 : 0;
    const bool anew = snapped || composed.dr_reset_counter != last_composed_->dr_reset_counter;
    if (!stationary && !anew) {
      const Largest step = SizeOf(StepBeside(*last_composed_, composed));
      corrections_ += step.m > kCorrectionM || step.rad > kCorrectionRad ? 1 : 0;
      Enlarge(step, &composed_);
      Enlarge(SizeOf(StepBeside(*last_published_, published)), &published_);
    }
  }
  last_composed_ = composed;
  last_published_ = published;
}

}  // namespace gw::sim

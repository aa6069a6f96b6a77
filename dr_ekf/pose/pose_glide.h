// Takes the jumps out of the pose for control. A correction of T_WO, after a loop, a blind span or
// a noisy image, is not made at once: the published pose goes over to the corrected one at a
// bounded rate, so that a controller sees the motion of dead reckoning and no more than that rate
// beside it (docs/adr/0045-pose-without-jumps.md).
//
// With E the correction that is outstanding, from the published body frame to the corrected one,
//   T_WB(published) = T_WB(corrected) * inv(E),   e = Log(E)
// every step takes from E at most rate * dt, of its translation and of its angle. The covariance is
// the second moment of the error about what is published: that of the corrected pose plus e * e^T.
//
// Dead reckoning that is wrong, by which the pose moves between two images, is no correction: what
// the corrections of the last images have in common, each over the time since the one before, is a
// motion of the robot that dead reckoning does not tell. The rate is larger by twice that (per
// axis: the least of them, where all have one sign).
//
// A correction is made at once when the robot stands still, when the rates are 0, when the first
// place in a map becomes known, and when the place was unknown or in doubt before. In the last two
// cases Pose::reset_counter moves on: nobody could have relied on the pose before.
//
// Pure: time comes with the poses; same calls, same bytes.
#pragma once

#include <deque>
#include <optional>

#include "common/contract/dead_reckoning.h"

namespace gw::dr_ekf {

struct GlideRates {
  double m_s = 0;    // of the position; 0: at once
  double rad_s = 0;  // of the rotation; 0: at once
};

class PoseGlide {
 public:
  explicit PoseGlide(const GlideRates& rates) : rates_(rates) {}

  // corrected: the next pose of the PoseComposer. stationary: of its DR state.
  Pose Push(const Pose& corrected, bool stationary);

 private:
  bool DrBeganAnew(const Pose& corrected) const {
    return corrected.dr_reset_counter != corrected_->dr_reset_counter;
  }
  SE3 Outstanding(const Pose& corrected, const SE3& T_OB) const;
  bool BeginsAnew(const Pose& corrected) const;
  void Observe(const Pose& corrected, const SE3& T_OB);
  Vector6d Untold() const;
  SE3 AfterOneStep(const SE3& outstanding, double dt_s) const;

  GlideRates rates_;
  std::optional<Pose> corrected_;              // the one before
  SE3 T_WO_;                                   // as published
  SE3 outstanding_;                            // E
  Utime corrected_at_;                         // the image before was latched
  std::deque<Vector6d> rates_of_corrections_;  // of the last images; m/s, rad/s, in the body frame
  uint32_t reset_counter_ = 0;
};

}  // namespace gw::dr_ekf

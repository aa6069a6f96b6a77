// The last seconds of DR states, and the motion between any two instants in them.
// Used by the front-end (prior between images), the POSE composer and the tests.
#pragma once

#include <deque>
#include <optional>

#include "common/contract/dead_reckoning.h"

namespace gw {

// Noise of a motion, split by how it goes on: two motions in a row share `coherent`, the constant
// twist error (body), and nothing else.
struct DrNoise {
  Matrix6d white = Matrix6d::Zero();     // m^2, rad^2; right perturbation of T_BaBb
  Matrix6d lever = Matrix6d::Zero();     // s; carries the twist error to the end of the motion
  Matrix6d coherent = Matrix6d::Zero();  // (m/s)^2, (rad/s)^2; its covariance
  Matrix6d Covariance() const { return white + lever * coherent * lever.transpose(); }
};

class DrHistory {
 public:
  // window: states older than this behind the newest are forgotten.
  explicit DrHistory(DurationUs window = Milliseconds(30000)) : window_(window) {}

  // Times must increase; a state that does not is refused (false) and counted by the caller.
  bool Push(const DrState& state);
  void Clear() { states_.clear(); }

  bool empty() const { return states_.empty(); }
  // Precondition: !empty().
  const DrState& newest() const { return states_.back(); }

  // T_OB at an instant, interpolated on the SE(3) geodesic; up to max_extrapolation past the newest
  // state with its velocity. Empty outside that range, and inside a gap where the counter changed.
  std::optional<SE3> PoseAt(Utime utime, DurationUs max_extrapolation) const;

  // Motion from a to b (a <= b), with covariance. Empty when either end is not covered (see PoseAt)
  // or a reset lies between them. noise, unless null: what the covariance is made of.
  std::optional<DrIncrement> Increment(Utime a, Utime b, DurationUs max_extrapolation,
                                       DrNoise* noise = nullptr) const;

 private:
  DurationUs window_;
  std::deque<DrState> states_;
};

}  // namespace gw

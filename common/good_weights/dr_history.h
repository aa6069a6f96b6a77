// The last seconds of DR states, and the motion between any two instants in them.
// Used by the front-end (prior between images), the POSE composer and the tests.
#pragma once

#include <deque>
#include <optional>

#include "common/contract/dead_reckoning.h"
#include "common/core/clock_watch.h"

namespace gw {

// What two motions in a row have in common: a constant twist error (6), and the errors of the
// scales of way and turn; all in sigmas, so that each part of a motion has the doubt of its time.
//
// The source learns while the robot drives. Its error e of then and of now are those of one optimal
// estimate before and after more was measured, E[e_then e_now] = min(sigma^2), so that their
// correlation is the smaller sigma over the larger. A turn there and back cancels a wrong scale
// only as far as that: what was learnt in between corrected the way back alone.
inline constexpr int kWayScale = 6;
inline constexpr int kTurnScale = 7;
using DrLever = Eigen::Matrix<double, 6, 8>;
using DrCoherent = Eigen::Matrix<double, 8, 8>;
using DrCommon = Eigen::Matrix<double, 8, 1>;

// Noise of a motion, split by how it goes on: see DrState.
struct DrNoise {
  Matrix6d white = Matrix6d::Zero();  // m^2, rad^2; right perturbation of T_BaBb
  DrLever lever = DrLever::Zero();    // carries the common errors, as they are at the end, there
  DrCoherent coherent = DrCoherent::Identity();  // their covariance
  DrCommon kept = DrCommon::Ones();  // their correlation with those at the begin, each with its own

  Matrix6d Covariance() const;

  // The motion begins where this state was the newest; `kept` counts from here.
  void Begin(const DrState& state);

  // The motion goes on by T_step for dt_s > 0, with the noise that `state` tells.
  void Append(const DrState& state, const SE3& T_step, double dt_s);

 private:
  void Follow(const DrCommon& sigma);

  DrCommon sigma_ = DrCommon::Zero();  // of the common errors at the end; 0: not told yet
};

// Past the newest state a robot is taken to go on at its velocity for so long. Wheels without an
// IMU may come five times a second; what may happen until then is in the noise of a motion.
inline constexpr DurationUs kMaxDrExtrapolation = Milliseconds(500);

class DrHistory {
 public:
  // window: states older than this behind the newest are forgotten.
  explicit DrHistory(DurationUs window = Milliseconds(30000)) : window_(window) {}

  // Times must increase; a state that is late is refused (false) and counted by the caller. When
  // the clock was set back, by what the source says (reset_counter) or by what its times show, the
  // history begins anew.
  bool Push(const DrState& state);
  void Clear() { states_.clear(); }

  bool empty() const { return states_.empty(); }
  // Precondition of both: !empty().
  const DrState& newest() const { return states_.back(); }
  const DrState& oldest() const { return states_.front(); }

  // T_OB at an instant, interpolated on the SE(3) geodesic; up to kMaxDrExtrapolation past the
  // newest state with its velocity. Empty outside that range, and inside a gap where the counter
  // changed.
  std::optional<SE3> PoseAt(Utime utime) const;

  // Motion from a to b (a <= b), with covariance. Empty when either end is not covered (see PoseAt)
  // or a reset lies between them. noise, unless null: what the covariance is made of.
  std::optional<DrIncrement> Increment(Utime a, Utime b, DrNoise* noise = nullptr) const;

 private:
  // Covariance of PoseAt beside what the states say: of what a robot does between two of them.
  Matrix6d BetweenStates(Utime utime) const;

  DurationUs window_;
  std::deque<DrState> states_;
  ClockWatch clock_;
};

}  // namespace gw

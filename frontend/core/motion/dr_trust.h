// Two witnesses: does dead reckoning (DR) do what it says, seen from healthy vision?
//
// Windows of kWindow in which vision carried every image, and was sure of it, are compared: the
// error
//
//   e = Log(inv(T_dr) T_vision),   S = cov_dr + cov_vision   (body axes)
//
// is what DR and vision together expect it to be when e_i^2 / S_ii is 1 in the mean. What DR claims
// is scaled by what it does: each axis by the mean of that ratio, where it is above 1. And DR whose
// errors along an axis are far beyond its claims in window after window (in a single one, while it
// has never agreed yet) is distrusted, until it agrees again: a wrong frame, sign, unit or scale, a
// stuck heading, another clock. While it is distrusted, healthy vision goes on without it; without
// vision it is still the best there is, with the noise it has shown. Until it has shown anything,
// its nominal noise stands beside what it claims (Weighted).
#pragma once

#include "common/core/se3.h"
#include "common/core/time.h"
#include "common/good_weights/dr_history.h"

namespace gw::frontend {

// Motion of the body over one window, as both witnesses have it; covariances are right
// perturbations, m^2, rad^2.
struct DrEvidence {
  SE3 T_dr;
  Matrix6d cov_dr = Matrix6d::Zero();
  SE3 T_vision;
  Matrix6d cov_vision = Matrix6d::Zero();
};

class DrTrust {
 public:
  static constexpr DurationUs kWindow = Milliseconds(1000);

  void Judge(const DrEvidence& evidence);

  bool trusted() const { return trusted_; }
  // Distrusted, and vision did not just stand still when DR was last seen to contradict it: vision
  // is not held by something that moves along.
  bool refuted() const { return !trusted_ && vision_moved_; }

  // The noise that DR has shown, given what it claims. Body axes.
  DrNoise Shown(const DrNoise& claimed) const;

  // Sigma_d of the prior of an image: the larger of nominal and shown covariance, where the nominal
  // sigma falls with the number n of windows in which DR has shown what it does, as 5 / (5 + n).
  // Any axes, the same for all three.
  Matrix6d Weighted(const Matrix6d& nominal, const Matrix6d& shown) const;

 private:
  bool trusted_ = true;
  bool vision_moved_ = false;          // in the newest window that contradicts
  bool proven_ = false;                // it has agreed for so long as ends distrust
  int contradicting_ = 0;              // windows in a row
  int agreeing_ = 0;                   // windows in a row, of those in which the robot moved
  int num_windows_ = 0;                // in which the robot moved
  Vector6d ratio_ = Vector6d::Ones();  // mean of e_i^2 / S_ii of the newest windows
};

}  // namespace gw::frontend

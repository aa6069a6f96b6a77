// What is wrong with dead reckoning (DR) that contradicts healthy vision? Most faults of a set-up
// are one constant: wheels in another frame, reversed, a wrong unit or radius, a camera turned on
// its base. The ways and turns of the compared windows tell it by least squares, on the floor (x,
// y, yaw of B; ways in small steps, as a constant twist has them):
//
//   vision's way = s R(phi) way of DR        vision's turn = k turn of DR
//
// A factor and a direction explain any one way: each window is judged by the constant that the
// other windows tell (cross-validation), and a constant explains them when it leaves no more than
// their noise.
#pragma once

#include <complex>
#include <deque>
#include <optional>
#include <string>

#include "frontend/core/motion/dr_trust.h"

namespace gw::frontend {

struct DrConstantFault {
  // Vision's way over that of DR, > 0, and the angle from DR's direction to vision's, rad in
  // (-pi, pi]; empty where no constant explains the ways.
  std::optional<double> way_factor, direction;
  // Vision's turn over that of DR; empty where none explains the turns.
  std::optional<double> turn_factor;

  bool empty() const { return !way_factor && !direction && !turn_factor; }
};

// The parts of a constant that are not as they should be.
DrConstantFault FaultOf(double way_factor, double direction, double turn_factor);

// Vision's way over that of DR, x + iy of the body, and vision's turn over that of DR; empty where
// no constant explains what moved, or too little did.
struct DrExplanation {
  std::optional<std::complex<double>> way;
  std::optional<double> turn;
};

class DrDisagreement {
 public:
  // A sigma of the factors of few windows; DrCalibration measures them on.
  static constexpr double kFactorSigma = 0.03;

  // One window, with DR as it is told.
  void Add(const DrEvidence& evidence);

  // From the newest twenty windows.
  DrExplanation Explain() const;

 private:
  // On the floor: a way is x + iy of the body, a turn a real number. Variances are of one part.
  struct Pair {
    std::complex<double> dr, vision;
    double var_dr, var_vision;
  };
  using Pairs = std::deque<Pair>;
  static std::optional<std::complex<double>> Factor(const Pairs& windows, double least);

  Pairs ways_, turns_;
};

// In words for HEALTH and reports, with what to set; empty when the fault is.
std::string Describe(const DrConstantFault& fault);

}  // namespace gw::frontend

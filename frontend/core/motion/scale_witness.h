// Whose lengths are right, where those of vision and dead reckoning (DR) differ by a factor? The
// accelerometer is a third witness: the DR filter measures with it how far the robot goes where the
// wheels say a metre, and how sure that is. What it knows beyond what was assumed of the wheels
// before the first motion is the accelerometer's; one start or stop tells the scale to 2 %. Where
// there is none, or it is unfit, the filter stays as sure as it began, and nothing follows.
#pragma once

#include <cstdint>
#include <string>

#include "common/contract/dead_reckoning.h"

namespace gw::frontend {

// What is wrong with the lengths that the camera tells.
struct LengthFault {
  double too_long = 1;     // by this factor
  bool corrected = false;  // it is taken out of them, and of the map

  bool found() const { return too_long != 1; }
};

// In words, with the value to set; empty for none.
std::string Describe(const LengthFault& fault);

class ScaleWitness {
 public:
  // After every state, as DR told it.
  void Observe(const DrState& told);

  // Vision tells `factor` times the way that DR tells (> 0). The log of the odds that DR is right,
  // and vision's lengths are that many times too long, against vision being right: the likelihoods
  // of what the accelerometer says. Zero: it says nothing.
  double LogOddsForDr(double factor) const;

 private:
  uint32_t reset_counter_ = 0;
  double prior_sigma_ = 0;  // the largest since DR began: nothing is known yet. 0: not told
  double sigma_ = 0;        // now
  double scale_ = 1;        // of the wheels, true way / measured way
};

}  // namespace gw::frontend

// The constant by which dead reckoning (DR) is wrong, taken out of it: wheels in another frame,
// reversed, in a wrong unit or of a wrong radius, a camera turned on its base. DR without it is as
// good a witness as any (docs/adr/0059-a-known-constant-is-taken-out.md).
//
//   way = way_factor Rz(direction) way told        turn = turn_factor turn told      (body, small
//   steps)
#pragma once

#include "common/contract/dead_reckoning.h"
#include "common/core/se3.h"
#include "frontend/core/motion/dr_disagreement.h"

namespace gw::frontend {

class DrConstant {
 public:
  // Takes over what is explained; where it is as it should be, the constant is none.
  void Take(const DrExplanation& explained);

  // The factor of the way has proven to be one of vision.
  void ForgetWayFactor() { way_factor_ = 1; }

  // All that is not as it should be; empty: DR is taken as told.
  DrConstantFault fault() const { return Beside(DrConstant()); }
  // ... and is not so in the other.
  DrConstantFault Beside(const DrConstant& other) const;

  // The state that follows `before`, where DR told that `told` follows `told_before`.
  DrState Follow(const DrState& before, const DrState& told_before, const DrState& told) const;

 private:
  double way_factor_ = 1;   // > 0
  double direction_ = 0;    // rad
  double turn_factor_ = 1;  // < 0: it turns the other way
};

}  // namespace gw::frontend

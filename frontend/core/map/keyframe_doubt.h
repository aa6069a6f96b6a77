// How far keyframes may be off from where the map begins.
//
// What vision mapped in one go hangs together as well as it can be seen. Across a span without
// vision the map hangs together by dead reckoning alone: the keyframes made in it, and all that is
// mapped from them, share the drift of that span. A pose that is found among them is exact there,
// and no surer of where the map begins than they are. A loop takes the doubt away.
#pragma once

#include <map>

#include "common/contract/map.h"
#include "common/core/se3.h"

namespace gw::frontend {

class KeyframeDoubt {
 public:
  // Covariance of the right perturbation of T_WC, for a camera that the keyframe sees at T_KC. Zero
  // for a keyframe of which nothing is kept.
  Matrix6d At(KeyframeId id, const SE3& T_KC) const;
  // The keyframe, at T_WK, has this one.
  void Set(KeyframeId id, const Matrix6d& cov_T_WK);
  void Clear() { doubts_.clear(); }

 private:
  std::map<KeyframeId, Matrix6d> doubts_;  // those that are not zero
};

}  // namespace gw::frontend

// Lengths that a camera tells, corrected by a factor.
#pragma once

#include <vector>

#include "common/contract/map.h"

namespace gw {

// As if the baseline, or the unit of depth, had been `factor` (> 0) times as large.
inline void ScaleLengths(double factor, std::vector<Feature>* features) {
  const auto by = static_cast<float>(factor);
  for (Feature& f : *features) {
    if (!f.has_disparity()) continue;
    f.u_right = f.u - (f.u - f.u_right) / by;
    if (f.has_depth()) f.depth *= by;
  }
}

}  // namespace gw

// Parts are not what their data sheet says: errors that one robot has for life.
#pragma once

#include "common/core/random.h"

namespace gw::sim {

// The error of one part: of either sign, between 0.6 and 1.4 times `size`, so that no seed gives a
// perfect robot.
inline double DrawError(CounterRng* rng, double size) {
  const double sign = rng->Below(2) == 0 ? -1 : 1;
  return sign * rng->Uniform(0.6, 1.4) * size;
}

}  // namespace gw::sim

// What must hold in every map. Violations are bugs (or a damaged file whose checksums hold).
#pragma once

#include <string>
#include <vector>

#include "backend/core/map/map.h"

namespace gw::backend {

struct MapFaults {
  int64_t count = 0;
  std::vector<std::string> texts;  // the first kMaxTexts, each naming its keyframe or landmark
  static constexpr size_t kMaxTexts = 20;
};

// Poses and points are finite and within 1000 km. Observations and the keyframes' feature slots
// name each other, sorted and once. Nothing is named after a keyframe newer than the newest: its
// name would be given again. Covisibility is what the observations say. The DR chain is
// linked both ways, forward in time, and has increments only between neighbours. Removed keyframes
// live on in keyframes that exist; merged landmarks do not exist.
MapFaults CheckMap(const Map& map);

}  // namespace gw::backend

// What a set of keyframes sees.
#pragma once

#include <algorithm>
#include <vector>

#include "backend/core/map/map.h"

namespace gw::backend {

// Landmarks that any of the keyframes observes, sorted, each once. Precondition: the keyframes
// exist.
std::vector<LandmarkId> SeenLandmarks(const Map& map, const auto& keyframes) {
  std::vector<LandmarkId> out;
  for (const KeyframeId id : keyframes) {
    for (const auto& [landmark, feature] : map.FindKeyframe(id)->seen) out.push_back(landmark);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace gw::backend

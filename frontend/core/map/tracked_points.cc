#include "frontend/core/map/tracked_points.h"

#include <map>

namespace gw::frontend {

void FollowMerges(const std::vector<LandmarkMerge>& merges, std::vector<TrackedPoint>* points) {
  if (merges.empty()) return;
  std::map<LandmarkId, LandmarkId> merged;
  for (const LandmarkMerge& m : merges) merged[m.from] = m.into;
  for (TrackedPoint& t : *points) {
    // A landmark may be merged more than once; the bound guards against a circle in bad data.
    for (size_t i = 0; i < merged.size(); ++i) {
      const auto it = merged.find(t.id);
      if (it == merged.end()) break;
      t.id = it->second;
    }
  }
}

}  // namespace gw::frontend

#include "frontend/core/map/tracked_points.h"

#include <algorithm>
#include <map>

namespace gw::frontend {
namespace {

std::vector<LandmarkId> Proven(const std::vector<TrackedPoint>& points) {
  std::vector<LandmarkId> proven;
  for (const TrackedPoint& t : points) {
    if (t.proven) proven.push_back(t.id);
  }
  std::sort(proven.begin(), proven.end());
  return proven;
}

}  // namespace

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

void KeepProven(const std::vector<TrackedPoint>& before, std::vector<TrackedPoint>* now) {
  const std::vector<LandmarkId> proven = Proven(before);
  for (TrackedPoint& t : *now) {
    t.proven = t.proven || std::binary_search(proven.begin(), proven.end(), t.id);
  }
}

int NumProven(const std::vector<TrackedPoint>& points, const std::vector<LandmarkId>& landmarks) {
  const std::vector<LandmarkId> proven = Proven(points);
  return static_cast<int>(std::count_if(landmarks.begin(), landmarks.end(), [&](LandmarkId id) {
    return id.valid() && std::binary_search(proven.begin(), proven.end(), id);
  }));
}

}  // namespace gw::frontend

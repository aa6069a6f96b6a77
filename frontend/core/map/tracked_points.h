// The landmarks that the newest image with a pose showed: the first to be looked for in the next.
#pragma once

#include <vector>

#include "common/contract/map.h"

namespace gw::frontend {

struct TrackedPoint {
  LandmarkId id;
  Descriptor descriptor;  // as seen in the last image
  int level = 0;          // of the pyramid, there
  // It was an inlier of a pose on which vision and dead reckoning agreed: it stands still.
  bool proven = false;
};

// Points whose landmark was merged into another stand for that one from now on.
void FollowMerges(const std::vector<LandmarkMerge>& merges, std::vector<TrackedPoint>* points);

// Marks those of `now` that are proven among `before`.
void KeepProven(const std::vector<TrackedPoint>& before, std::vector<TrackedPoint>* now);

// Proven points among the landmarks (invalid ones are skipped).
int NumProven(const std::vector<TrackedPoint>& points, const std::vector<LandmarkId>& landmarks);

}  // namespace gw::frontend

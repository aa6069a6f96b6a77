// The landmarks that the newest image with a pose showed: the first to be looked for in the next.
#pragma once

#include <vector>

#include "common/contract/map.h"

namespace gw::frontend {

struct TrackedPoint {
  LandmarkId id;
  Descriptor descriptor;  // as seen in the last image
  int level = 0;          // of the pyramid, there
};

// Points whose landmark was merged into another stand for that one from now on.
void FollowMerges(const std::vector<LandmarkMerge>& merges, std::vector<TrackedPoint>* points);

}  // namespace gw::frontend

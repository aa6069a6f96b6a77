// Landmarks that are the same point, created twice, become one; landmarks get the observations that
// tracking missed.
#pragma once

#include <utility>
#include <vector>

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

struct FusionCounts {
  int merged = 0;
  int observations = 0;
};

// Projects the newest keyframe's landmarks into its neighbours (two hops of covisibility) and
// theirs into it. A landmark that falls on a feature without landmark gains the observation; on a
// feature of another landmark, the one with more observations (on a tie the older) absorbs the
// other.
FusionCounts FuseWithNeighbours(Map& map, const MappingContext& context);

// For loop closing: features of `keyframe` show these landmarks. Landmarks that are gone are left
// out.
FusionCounts FuseMatches(Map& map, const MappingContext& context, KeyframeId keyframe,
                         const std::vector<std::pair<int32_t, LandmarkId>>& matches);

// For loop closing: each side's landmarks are projected into the other's keyframes.
FusionCounts FuseGroups(Map& map, const MappingContext& context, const std::vector<KeyframeId>& a,
                        const std::vector<KeyframeId>& b);

}  // namespace gw::backend

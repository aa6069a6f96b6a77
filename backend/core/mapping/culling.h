// Keeping the map small: landmarks that do not prove themselves, keyframes that add nothing.
#pragma once

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

// Looks at the landmarks that the last kProbation keyframes before the newest created. One goes
// when at least two later keyframes should see it and fewer than config.landmark_min_found_ratio of
// them do, and, at the end of probation, when some keyframe should see it and none but its creator
// does. Keyframes that track next to nothing (dark, blank) are no witnesses against a landmark.
// Returns how many went.
inline constexpr int kProbation = 3;
int CullYoungLandmarks(Map& map, const MappingContext& context);

// The ten newest keyframes stay. Judged are the next older one and those that share landmarks with
// it, newer ones first: one goes when more than config.redundant_share of its proven landmarks with
// depth are seen by at least config.redundant_observers others at the same or a finer scale
// (ORB-SLAM2's rule, reference methods 4d, but for `proven`: at least config.redundant_observers
// see it at all). What hardly anybody finds again holds no keyframe
// (docs/adr/0013-keyframes-of-a-mapped-place.md). The first keyframe stays too, and those where a
// span that vision carries meets one that it does not: one DR edge cannot stand for the two.
// The landmarks of one that goes keep their other observations; one that is left with a single one
// goes too. Returns how many keyframes went.
int CullRedundantKeyframes(Map& map, const MappingContext& context);

}  // namespace gw::backend

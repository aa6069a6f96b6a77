// What follows of a landmark's state from its position and observations.
#pragma once

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

// Recomputes normal and distance range of a landmark: normal_W is the mean of the unit vectors from
// its observers to it; max_distance is the distance from its reference observer (its creator, else
// the first) times scale_factor^level there, so that the landmark shows at level 0 from
// max_distance; min_distance is where it would show at the highest level. No effect on a landmark
// without observations. Precondition: the landmark is in the map.
void RefreshGeometry(Map& map, const MappingContext& context, LandmarkId id);

// Takes the descriptor of the observation with the least median distance to the others (the newest
// kMaxCompared observations compete).
void RefreshDescriptor(Map& map, LandmarkId id);

}  // namespace gw::backend

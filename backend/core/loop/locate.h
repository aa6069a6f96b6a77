// Where in the map was an image taken, without any hint?
#pragma once

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "backend/core/place/place_index.h"
#include "common/contract/place.h"

namespace gw::backend {

// Fits the image at the places that look most like it. Not found when none fits, or when another
// place fits nearly as well (kRivalShare of the matches) elsewhere: look-alikes are told apart by
// moving on, not by guessing. The answer's seq is left to the sender.
inline constexpr double kRivalShare = 0.6;
PlaceMatch Locate(const Map& map, const MappingContext& context, const PlaceIndex& places,
                  const PlaceQuery& query);

}  // namespace gw::backend

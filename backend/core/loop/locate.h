// Where in the map was an image taken, without any hint?
#pragma once

#include <functional>
#include <optional>

#include "backend/core/loop/place_fit.h"
#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "backend/core/place/place_index.h"
#include "common/contract/place.h"

namespace gw::backend {

// An image, fitted at the place that looks most like it.
struct LocatedImage {
  PlaceFit fit;
  KeyframeId place;  // the keyframe that looks most like the image
};

// Fits the image at the places that look most like it, of those whose keyframes are `asked`. Empty
// when none fits, or when another place fits nearly as well (kRivalShare of the matches) elsewhere:
// look-alikes are told apart by moving on, not by guessing. Places of two pieces of the map are
// always elsewhere.
inline constexpr double kRivalShare = 0.6;
std::optional<LocatedImage> LocateImage(const Map& map, const MappingContext& context,
                                        const PlaceIndex& places, const MapKeyframe& image,
                                        uint64_t seed,
                                        const std::function<bool(KeyframeId)>& asked);

// The same for a query, in the whole map. The answer's seq is left to the sender.
PlaceMatch Locate(const Map& map, const MappingContext& context, const PlaceIndex& places,
                  const PlaceQuery& query);

}  // namespace gw::backend

// Which part of the map local bundle adjustment moves, and what holds it in place.
#pragma once

#include <optional>

#include "backend/core/bundle/local_ba.h"
#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

// The window of the newest keyframe:
//  - free: it, the best covisible keyframes, and for variants with DR in local BA its predecessors
//    in time: a few always, and on along the chain while vision binds them weakly;
//  - landmarks: what free keyframes see, with at least two observations in the window;
//  - fixed: other keyframes that see these (at most config.local_fixed_keyframes, those that see
//    most), and the temporal neighbours of weakly bound free ones. The first keyframe of
//    the map, or of a piece of it, is always fixed; without any fixed one, the oldest of the window
//    is (gauge).
// Empty while the map has fewer than two keyframes.
std::optional<LocalBaJob> CutLocalWindow(const Map& map, const MappingContext& context);

// Every keyframe but the first of each piece, and every landmark with two observations, for global
// BA; in variants that have them there, DR edges as WholeMapEdgeCovariance weighs them, from the
// alpha that local BA left. Empty with fewer than two keyframes.
std::optional<LocalBaJob> CutWholeMap(const Map& map, const MappingContext& context);

}  // namespace gw::backend

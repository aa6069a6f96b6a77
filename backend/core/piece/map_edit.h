// Maps made from other maps: without some keyframes, or of two. The results hold together whatever
// goes, and have no history: nothing lives on of what left.
#pragma once

#include <cstdint>
#include <functional>

#include "backend/core/map/map.h"

namespace gw::backend {

// The map of the keyframes to be kept. Landmarks that none of them observes are gone. Where dead
// reckoning led through keyframes that go, it leads on over the gap.
Map KeepKeyframes(const Map& map, const std::function<bool(const MapKeyframe&)>& keep);

// Both in one map: the keyframes of `b` follow those of `a`, with ids greater by `a`'s newest, as a
// piece of their own.
Map PutTogether(const Map& a, const Map& b);

}  // namespace gw::backend

// GRID and OBSTACLES, as wire.h for the other messages.
#pragma once

#include "common/contract/grid.h"
#include "common/wire/wire.h"

namespace gw::wire {

Bytes Encode(const GridUpdate& update);
Bytes Encode(const ObstacleView& view);
template <>
Result<GridUpdate> Decode(ByteSpan message);
template <>
Result<ObstacleView> Decode(ByteSpan message);

}  // namespace gw::wire

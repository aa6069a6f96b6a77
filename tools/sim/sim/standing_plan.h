// A plan of what truly stands in a simulated building: walls and furniture as they were built, for
// comparing floor maps with. The floor map that the building was made from is not that: walls are
// smoothed, and furniture is not in it.
#pragma once

#include "grid/core/floor_image.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/sim/sim/world.h"

namespace gw::sim {

// Occupied: cells that an upright surface crosses between the two heights (m). Unknown: other cells
// inside walls of `map`. The rest is free.
grid::FloorImage StandingPlan(const World& world, const floorplan::FloorMap& map, double from_m,
                              double to_m, double cell_m);

}  // namespace gw::sim

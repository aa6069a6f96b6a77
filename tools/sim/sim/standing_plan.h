// A plan of what truly stands in a simulated building: walls and furniture as they were built, for
// comparing floor maps with. The floor map that the building was made from is not that: walls are
// smoothed, and furniture is not in it.
#pragma once

#include "grid/core/floor_image.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/sim/sim/world.h"

namespace gw::sim {

// Occupied: cells that an upright surface crosses between the two heights (m). Free: what can be
// reached from `inside` without crossing one. The rest, the inside of walls and furniture, is
// unknown. map: whose rectangle the plan has.
grid::FloorImage StandingPlan(const World& world, const floorplan::FloorMap& map,
                              const Eigen::Vector2d& inside, double from_m, double to_m,
                              double cell_m);

}  // namespace gw::sim

#include "tools/sim/sim/standing_plan.h"

#include <cmath>

namespace gw::sim {

grid::FloorImage StandingPlan(const World& world, const floorplan::FloorMap& map, double from_m,
                              double to_m, double cell_m) {
  grid::FloorImage plan;
  plan.cell_m = cell_m;
  const auto cell_of = [cell_m](double p) { return static_cast<int32_t>(std::floor(p / cell_m)); };
  plan.first_x = cell_of(map.origin.x());
  plan.first_y = cell_of(map.origin.y());
  plan.width = cell_of(map.origin.x() + map.width * map.resolution) - plan.first_x + 1;
  plan.height = cell_of(map.origin.y() + map.height * map.resolution) - plan.first_y + 1;
  for (int y = 0; y < plan.height; ++y) {
    for (int x = 0; x < plan.width; ++x) {
      const Eigen::Vector2i cell =
          map.CellOf(cell_m * Eigen::Vector2d(plan.first_x + x + 0.5, plan.first_y + y + 0.5));
      plan.cells.push_back(map.Occupied(cell.x(), cell.y()) ? CellState::kUnknown
                                                            : CellState::kFree);
    }
  }
  for (const Surface& surface : world.surfaces()) {
    const bool upright = std::abs(surface.v.z()) > 0.5;
    const double top = surface.origin.z();
    if (!upright || top <= from_m || top - surface.v_length >= to_m) continue;
    const double step = cell_m / 8;
    for (double s = 0; s <= surface.u_length; s += step) {
      const Eigen::Vector3d p = surface.origin + s * surface.u;
      const int x = cell_of(p.x()) - plan.first_x, y = cell_of(p.y()) - plan.first_y;
      if (x < 0 || y < 0 || x >= plan.width || y >= plan.height) continue;
      plan.cells[static_cast<size_t>(y) * static_cast<size_t>(plan.width) +
                 static_cast<size_t>(x)] = CellState::kOccupied;
    }
  }
  return plan;
}

}  // namespace gw::sim

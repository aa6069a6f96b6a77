#include "tools/sim/sim/standing_plan.h"

#include <cmath>
#include <vector>

namespace gw::sim {
namespace {

// Makes free what can be reached from a cell over unknown ones.
void Flood(int x, int y, grid::FloorImage* plan) {
  std::vector<Eigen::Vector2i> open = {{x, y}};
  while (!open.empty()) {
    const Eigen::Vector2i at = open.back();
    open.pop_back();
    if (at.x() < 0 || at.y() < 0 || at.x() >= plan->width || at.y() >= plan->height) continue;
    CellState& state = plan->cells[static_cast<size_t>(at.y()) * static_cast<size_t>(plan->width) +
                                   static_cast<size_t>(at.x())];
    if (state != CellState::kUnknown) continue;
    state = CellState::kFree;
    for (const auto& step : {Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, 1),
                             Eigen::Vector2i(0, -1)}) {
      open.push_back(at + step);
    }
  }
}

}  // namespace

grid::FloorImage StandingPlan(const World& world, const floorplan::FloorMap& map,
                              const Eigen::Vector2d& inside, double from_m, double to_m,
                              double cell_m) {
  grid::FloorImage plan;
  plan.cell_m = cell_m;
  const auto cell_of = [cell_m](double p) { return static_cast<int32_t>(std::floor(p / cell_m)); };
  plan.first_x = cell_of(map.origin.x());
  plan.first_y = cell_of(map.origin.y());
  plan.width = cell_of(map.origin.x() + map.width * map.resolution) - plan.first_x + 1;
  plan.height = cell_of(map.origin.y() + map.height * map.resolution) - plan.first_y + 1;
  plan.cells.assign(static_cast<size_t>(plan.width) * static_cast<size_t>(plan.height),
                    CellState::kUnknown);
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
  Flood(cell_of(inside.x()) - plan.first_x, cell_of(inside.y()) - plan.first_y, &plan);
  return plan;
}

}  // namespace gw::sim

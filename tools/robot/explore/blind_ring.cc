#include "tools/robot/explore/blind_ring.h"

#include <cmath>
#include <numbers>
#include <set>

namespace gw::explore {

std::vector<Eigen::Vector2d> FreeByLookingOver(const floorplan::FloorMap& map,
                                               const Eigen::Vector2d& robot, double ring_m) {
  std::set<int> free;
  const double step = 0.5 * map.resolution;
  const int rays = static_cast<int>(std::ceil(2 * std::numbers::pi * ring_m / step));
  for (int ray = 0; ray < rays; ++ray) {
    const double yaw = 2 * std::numbers::pi * ray / rays;
    const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
    std::set<int> over;
    for (double range = 0; range <= ring_m; range += step) {
      const Eigen::Vector2i cell = map.CellOf(robot + range * direction);
      if (!map.InMap(cell.x(), cell.y()) || map.Occupied(cell.x(), cell.y())) break;
      if (map.Unknown(cell.x(), cell.y())) {
        over.insert(map.index(cell.x(), cell.y()));
        continue;
      }
      free.merge(over);
      over.clear();
    }
  }
  std::vector<Eigen::Vector2d> centres;
  centres.reserve(free.size());
  for (const int cell : free) centres.push_back(map.CentreOf(cell % map.width, cell / map.width));
  return centres;
}

}  // namespace gw::explore

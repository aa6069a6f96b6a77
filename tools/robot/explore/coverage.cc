#include "tools/robot/explore/coverage.h"

#include <cmath>

#include "tools/robot/explore/way_lengths.h"

namespace gw::explore {
namespace {

// The plan's cells that lie under the robot at one of its places.
std::vector<uint8_t> FloorThatCanBeCovered(const floorplan::FloorMap& plan,
                                           const Eigen::Vector2d& start, double radius) {
  const std::vector<float> way = WayLengths(plan, start, radius);
  floorplan::FloorMap places = plan;
  for (size_t i = 0; i < way.size(); ++i) places.occupied[i] = std::isfinite(way[i]) ? 1 : 0;
  const std::vector<float> from_place = floorplan::DistanceToOccupied(places, 2 * radius);
  std::vector<uint8_t> covered(way.size());
  for (size_t i = 0; i < way.size(); ++i) {
    covered[i] = from_place[i] <= static_cast<float>(radius) && plan.occupied[i] == 0 ? 1 : 0;
  }
  return covered;
}

}  // namespace

Coverage CoverageOf(const floorplan::FloorMap& plan, const Eigen::Vector2d& start,
                    double robot_radius_m, const floorplan::FloorMap& own, const SE3& T_MG) {
  const std::vector<uint8_t> covered = FloorThatCanBeCovered(plan, start, robot_radius_m);
  const double cell_m2 = plan.resolution * plan.resolution;
  Coverage out;
  for (int y = 0; y < plan.height; ++y) {
    for (int x = 0; x < plan.width; ++x) {
      if (covered[plan.index(x, y)] == 0) continue;
      out.reachable_m2 += cell_m2;
      const Eigen::Vector2d p = plan.CentreOf(x, y);
      const Eigen::Vector3d p_M = T_MG * Eigen::Vector3d(p.x(), p.y(), 0);
      const Eigen::Vector2i cell = own.CellOf(p_M.head<2>());
      const bool free = own.InMap(cell.x(), cell.y()) && !own.Occupied(cell.x(), cell.y()) &&
                        !own.Unknown(cell.x(), cell.y());
      if (free) out.seen_m2 += cell_m2;
    }
  }
  return out;
}

}  // namespace gw::explore

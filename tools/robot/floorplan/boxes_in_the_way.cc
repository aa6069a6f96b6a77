#include "tools/robot/floorplan/boxes_in_the_way.h"

#include <algorithm>

#include "common/core/random.h"
#include "tools/robot/floorplan/planner.h"

namespace gw::floorplan {
namespace {

using Eigen::Vector2d;

constexpr double kFromStops = 0.8;  // m, from the middle of a box
constexpr double kFromBoxes = 1.5;  // m, between two boxes
constexpr int kTries = 200;

bool FarFromAll(const Vector2d& p, const std::vector<Vector2d>& others, double distance) {
  return std::all_of(others.begin(), others.end(),
                     [&](const Vector2d& o) { return (o - p).norm() >= distance; });
}

}  // namespace

FloorMap WithBox(FloorMap map, const Vector2d& centre, double side) {
  const double half = 0.5 * side;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const Vector2d apart = (map.CentreOf(x, y) - centre).cwiseAbs();
      if (apart.maxCoeff() <= half) map.occupied[map.index(x, y)] = 1;
    }
  }
  return map;
}

std::vector<Vector2d> PlacesInTheWay(const FloorMap& map, const std::vector<Waypoint>& stops,
                                     double clearance, double side, int count, uint64_t seed) {
  const std::vector<Waypoint> visit = MoveStopsFromWalls(map, stops, clearance);
  const auto legs = PlanLegs(map, visit, clearance);
  std::vector<Vector2d> way, taken, places;
  if (!legs) return places;
  for (const Leg& leg : *legs) way.insert(way.end(), leg.begin(), leg.end());
  for (const Waypoint& stop : visit) taken.push_back(stop.position);
  FloorMap world = map;
  CounterRng rng(seed, 0xB0, 0);
  for (int i = 0; i < kTries && static_cast<int>(places.size()) < count; ++i) {
    const Vector2d on_way = way[rng.Below(static_cast<uint32_t>(way.size()))];
    // At the corner of four cells, so that an even number of them is covered exactly.
    const Vector2d cell = ((on_way - map.origin) / map.resolution).array().round();
    const Vector2d p = map.origin + map.resolution * cell;
    if (!FarFromAll(p, taken, kFromStops) || !FarFromAll(p, places, kFromBoxes)) continue;
    FloorMap with = WithBox(world, p, side);
    if (!PlanLegs(with, visit, clearance)) continue;
    places.push_back(p);
    world = std::move(with);
  }
  return places;
}

}  // namespace gw::floorplan

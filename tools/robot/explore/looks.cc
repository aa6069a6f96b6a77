#include "tools/robot/explore/looks.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/robot/explore/sight_rays.h"

namespace gw::explore {
namespace {

// Cell of W of the map's first one.
Eigen::Vector2i FirstCell(const floorplan::FloorMap& map) {
  return (map.origin / map.resolution).array().round().cast<int>();
}

}  // namespace

double RangeLeft(const Sight& sight, uint8_t looks) {
  return looks >= kMostLooks ? 0 : sight.max_range_m / (1 + looks);
}

void LookCounts::Add(const floorplan::FloorMap& map, const floorplan::Waypoint& place,
                     const Sight& sight, double least_m) {
  const std::vector<uint8_t> open = OpenCells(map);
  const std::vector<uint8_t> looks = On(map);
  const SightRays rays(map, open, looks, sight);
  const Eigen::Vector2i first = FirstCell(map);
  // With their neighbours, since the edge of what is seen moves by a cell from look to look.
  std::set<std::pair<int, int>> cells;
  for (const Frontier& frontier : FindFrontiers(map, GivenUp(looks), least_m)) {
    for (const int cell : frontier.cells) {
      const int x = cell % map.width, y = cell / map.width;
      if (!rays.LooksPast(place, map.CentreOf(x, y))) continue;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) cells.emplace(first.y() + y + dy, first.x() + x + dx);
      }
    }
  }
  for (const auto& cell : cells) {
    uint8_t& count = counts_[cell];
    count = std::min<uint8_t>(kMostLooks, static_cast<uint8_t>(count + 1));
  }
}

std::vector<uint8_t> LookCounts::On(const floorplan::FloorMap& map) const {
  std::vector<uint8_t> looks(map.occupied.size(), 0);
  const Eigen::Vector2i first = FirstCell(map);
  for (const auto& [cell, count] : counts_) {
    const int x = cell.second - first.x(), y = cell.first - first.y();
    if (map.InMap(x, y)) looks[map.index(x, y)] = count;
  }
  return looks;
}

std::vector<uint8_t> GivenUp(const std::vector<uint8_t>& looks) {
  std::vector<uint8_t> out(looks.size());
  std::transform(looks.begin(), looks.end(), out.begin(),
                 [](uint8_t count) { return static_cast<uint8_t>(count >= kMostLooks); });
  return out;
}

}  // namespace gw::explore

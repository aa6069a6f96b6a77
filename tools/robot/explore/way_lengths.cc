#include "tools/robot/explore/way_lengths.h"

#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "tools/robot/floorplan/planner.h"

namespace gw::explore {

std::vector<float> WayLengths(const floorplan::FloorMap& map, const Eigen::Vector2d& from,
                              double clearance) {
  std::vector<float> length(map.occupied.size(), std::numeric_limits<float>::infinity());
  if (length.empty()) return length;
  const std::vector<float> room = floorplan::DistanceToNotFree(map, clearance + 2 * map.resolution);
  const auto can_stand = [&](int x, int y) {
    return map.InMap(x, y) && static_cast<double>(room[map.index(x, y)]) >= clearance;
  };
  const Eigen::Vector2i begin =
      map.CellOf(floorplan::MoveStopsFromWalls(map, {{from, 0}}, clearance).front().position);
  if (!can_stand(begin.x(), begin.y())) return length;
  using Entry = std::pair<float, int>;  // length, cell: ties go to the lower cell
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  length[map.index(begin.x(), begin.y())] = 0;
  queue.emplace(0.0F, map.index(begin.x(), begin.y()));
  while (!queue.empty()) {
    const auto [way, cell] = queue.top();
    queue.pop();
    if (way > length[cell]) continue;
    const int cx = cell % map.width, cy = cell / map.width;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!can_stand(cx + dx, cy + dy)) continue;
        const auto further = static_cast<float>(way + map.resolution * std::hypot(dx, dy));
        float& known = length[map.index(cx + dx, cy + dy)];
        if (further >= known) continue;
        known = further;
        queue.emplace(further, map.index(cx + dx, cy + dy));
      }
    }
  }
  return length;
}

}  // namespace gw::explore

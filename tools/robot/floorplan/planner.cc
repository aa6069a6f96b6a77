#include "tools/robot/floorplan/planner.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <sstream>

namespace gw::floorplan {
namespace {

using Eigen::Vector2d;

constexpr double kComfort = 0.7;  // m from walls beyond which the planner asks for no more

struct Grid {
  const FloorMap& map;
  const std::vector<float>& distance;
  double clearance;

  bool Free(int x, int y) const {
    return map.InMap(x, y) && distance[map.index(x, y)] >= clearance;
  }
  double Cost(int x, int y) const {
    const double lack = std::max(0.0, kComfort - distance[map.index(x, y)]) / kComfort;
    return 1 + 4 * lack * lack;
  }
};

// Cells from `from` to `to`, both included; empty when there is no way.
std::vector<int> AStar(const Grid& grid, const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
  const FloorMap& map = grid.map;
  std::vector<float> best(map.occupied.size(), std::numeric_limits<float>::infinity());
  std::vector<int> parent(map.occupied.size(), -1);
  using Entry = std::pair<double, int>;  // estimate, cell: ties go to the lower cell
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto heuristic = [&](int x, int y) { return std::hypot(x - to.x(), y - to.y()); };
  const int start = map.index(from.x(), from.y());
  const int goal = map.index(to.x(), to.y());
  best[start] = 0;
  open.emplace(heuristic(from.x(), from.y()), start);
  while (!open.empty()) {
    const auto [estimate, cell] = open.top();
    open.pop();
    if (cell == goal) break;
    const int cx = cell % map.width, cy = cell / map.width;
    if (estimate > best[cell] + heuristic(cx, cy) + 1e-3) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if ((dx == 0 && dy == 0) || !grid.Free(cx + dx, cy + dy)) continue;
        const int next = map.index(cx + dx, cy + dy);
        const double cost = best[cell] + std::hypot(dx, dy) * grid.Cost(cx + dx, cy + dy);
        if (cost + 1e-6 < best[next]) {
          best[next] = static_cast<float>(cost);
          parent[next] = cell;
          open.emplace(best[next] + heuristic(cx + dx, cy + dy), next);
        }
      }
    }
  }
  std::vector<int> cells;
  if (goal != start && parent[goal] < 0) return cells;
  for (int cell = goal; cell >= 0; cell = parent[cell]) cells.push_back(cell);
  std::reverse(cells.begin(), cells.end());
  return cells;
}

Leg Resample(const Leg& in) {
  Leg out = {in.front()};
  double rest = kLegSpacing;
  for (size_t i = 1; i < in.size(); ++i) {
    Vector2d a = in[i - 1];
    double length = (in[i] - a).norm();
    while (length >= rest) {
      a += (in[i] - a) * (rest / length);
      length -= rest;
      rest = kLegSpacing;
      out.push_back(a);
    }
    rest -= length;
  }
  if ((out.back() - in.back()).norm() > 1e-3) out.push_back(in.back());
  return out;
}

void SmoothLeg(const Grid& grid, Leg* leg) {
  for (int round = 0; round < 150; ++round) {
    for (size_t i = 1; i + 1 < leg->size(); ++i) {
      const Vector2d moved = (*leg)[i] + 0.4 * ((*leg)[i - 1] + (*leg)[i + 1] - 2 * (*leg)[i]);
      const double before = DistanceAt(grid.map, grid.distance, (*leg)[i]);
      const double after = DistanceAt(grid.map, grid.distance, moved);
      if (after >= std::min(before, grid.clearance + 0.15)) (*leg)[i] = moved;
    }
  }
}

std::string Place(const Waypoint& w) {
  std::ostringstream out;
  out << "(" << w.position.x() << ", " << w.position.y() << ")";
  return out.str();
}

}  // namespace

std::vector<Waypoint> MoveStopsFromWalls(const FloorMap& map, std::vector<Waypoint> stops,
                                         double clearance) {
  const std::vector<float> distance = DistanceToOccupied(map, 2.0);
  const Grid grid{map, distance, clearance};
  for (Waypoint& stop : stops) {
    const Eigen::Vector2i cell = map.CellOf(stop.position);
    if (grid.Free(cell.x(), cell.y())) continue;
    const int reach = static_cast<int>(std::ceil(kMaxStopMove / map.resolution));
    double best = kMaxStopMove;
    Vector2d moved = stop.position;
    for (int y = cell.y() - reach; y <= cell.y() + reach; ++y) {
      for (int x = cell.x() - reach; x <= cell.x() + reach; ++x) {
        const double move = (map.CentreOf(x, y) - stop.position).norm();
        if (!grid.Free(x, y) || move >= best) continue;
        best = move;
        moved = map.CentreOf(x, y);
      }
    }
    stop.position = moved;
  }
  return stops;
}

Result<std::vector<Leg>> PlanLegs(const FloorMap& map, const std::vector<Waypoint>& visit,
                                  double clearance) {
  const std::vector<float> distance = DistanceToOccupied(map, 2.0);
  const Grid grid{map, distance, clearance};
  for (size_t i = 0; i < visit.size(); ++i) {
    const Eigen::Vector2i cell = map.CellOf(visit[i].position);
    const std::string who = "stop " + std::to_string(i) + " at " + Place(visit[i]);
    if (!map.InMap(cell.x(), cell.y())) {
      return Error{ErrorCode::kBadData, who + " lies outside the map"};
    }
    if (!grid.Free(cell.x(), cell.y())) {
      return Error{ErrorCode::kBadData, who +
                                            " is in a wall, or nearer to one than the robot can "
                                            "stand"};
    }
  }
  std::vector<Leg> legs;
  for (size_t i = 0; i + 1 < visit.size(); ++i) {
    const auto cells =
        AStar(grid, map.CellOf(visit[i].position), map.CellOf(visit[i + 1].position));
    if (cells.empty()) {
      return Error{ErrorCode::kBadData, "stop " + std::to_string(i + 1) + " at " +
                                            Place(visit[i + 1]) + " cannot be reached from " +
                                            Place(visit[i])};
    }
    Leg leg;
    for (const int cell : cells) leg.push_back(map.CentreOf(cell % map.width, cell / map.width));
    leg.front() = visit[i].position;
    if (leg.size() == 1) leg.push_back(visit[i + 1].position);
    leg.back() = visit[i + 1].position;
    leg = Resample(leg);
    SmoothLeg(grid, &leg);
    legs.push_back(Resample(leg));
  }
  return legs;
}

}  // namespace gw::floorplan

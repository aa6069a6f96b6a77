#include "tools/robot/floorplan/planner.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <sstream>

namespace gw::floorplan {
namespace {

using Eigen::Vector2d;

constexpr double kComfort = 0.7;   // m from walls beyond which the planner asks for no more
constexpr double kFarthest = 2.0;  // m to which distances are told

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

// Empty when the robot can stand there.
std::string WhyItCannotStand(const Grid& grid, const Waypoint& stop) {
  const FloorMap& map = grid.map;
  const Eigen::Vector2i cell = map.CellOf(stop.position);
  if (!map.InMap(cell.x(), cell.y())) return "lies outside the map";
  if (map.Unknown(cell.x(), cell.y())) {
    return "lies in unknown cells of the map, where the robot never drives";
  }
  if (grid.Free(cell.x(), cell.y())) return "";
  const std::vector<float> to_wall = DistanceToOccupied(map, kFarthest);
  if (to_wall[map.index(cell.x(), cell.y())] >= grid.clearance) {
    return "is nearer to unknown cells of the map than the robot can stand";
  }
  return "is in a wall, or nearer to one than the robot can stand";
}

// For the message: whether there would be a way if all that is unknown were free.
std::string WhyThereIsNoWay(const Grid& grid, const Waypoint& from, const Waypoint& to) {
  if (grid.map.unknown.empty()) return "";
  const std::vector<float> to_wall = DistanceToOccupied(grid.map, kFarthest);
  const Grid walls_only{grid.map, to_wall, grid.clearance};
  const bool through_unknown =
      !AStar(walls_only, grid.map.CellOf(from.position), grid.map.CellOf(to.position)).empty();
  return through_unknown ? " but through unknown cells of the map, where the robot never drives"
                         : "";
}

Leg LegOf(const Grid& grid, const std::vector<int>& cells, const Waypoint& from,
          const Waypoint& to) {
  const FloorMap& map = grid.map;
  Leg leg;
  for (const int cell : cells) leg.push_back(map.CentreOf(cell % map.width, cell / map.width));
  leg.front() = from.position;
  if (leg.size() == 1) leg.push_back(to.position);
  leg.back() = to.position;
  leg = Resample(leg);
  SmoothLeg(grid, &leg);
  return Resample(leg);
}

}  // namespace

std::vector<Waypoint> MoveStopsFromWalls(const FloorMap& map, std::vector<Waypoint> stops,
                                         double clearance) {
  const std::vector<float> distance = DistanceToNotFree(map, kFarthest);
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

Tour PlanTour(const FloorMap& map, const std::vector<Waypoint>& stops, double clearance) {
  const std::vector<float> distance = DistanceToNotFree(map, kFarthest);
  const Grid grid{map, distance, clearance};
  Tour tour;
  for (size_t i = 0; i < stops.size(); ++i) {
    const Waypoint& to = stops[i];
    const std::string why = WhyItCannotStand(grid, to);
    if (!why.empty()) {
      tour.refused.push_back({static_cast<int>(i), Place(to) + " " + why});
      continue;
    }
    if (!tour.visited.empty()) {
      const Waypoint& from = stops[tour.visited.back()];
      const auto cells = AStar(grid, map.CellOf(from.position), map.CellOf(to.position));
      if (cells.empty()) {
        tour.refused.push_back({static_cast<int>(i), Place(to) + " cannot be reached from " +
                                                         Place(from) +
                                                         WhyThereIsNoWay(grid, from, to)});
        continue;
      }
      tour.legs.push_back(LegOf(grid, cells, from, to));
    }
    tour.visited.push_back(static_cast<int>(i));
  }
  return tour;
}

Result<std::vector<Leg>> PlanLegs(const FloorMap& map, const std::vector<Waypoint>& visit,
                                  double clearance) {
  Tour tour = PlanTour(map, visit, clearance);
  if (tour.refused.empty()) return std::move(tour.legs);
  std::string text;
  for (const RefusedStop& refused : tour.refused) {
    text += (text.empty() ? "" : "; ") + ("stop " + std::to_string(refused.stop) + " at ") +
            refused.why;
  }
  return Error{ErrorCode::kBadData, text};
}

}  // namespace gw::floorplan

#include "tools/sim/planner.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <queue>
#include <sstream>

#include "tools/sim/base.h"

namespace gw::sim {
namespace {

using Eigen::Vector2d;

constexpr double kComfort = 0.7;  // m from walls beyond which the planner asks for no more
constexpr double kSpacing = 0.05;

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
  double rest = kSpacing;
  for (size_t i = 1; i < in.size(); ++i) {
    Vector2d a = in[i - 1];
    double length = (in[i] - a).norm();
    while (length >= rest) {
      a += (in[i] - a) * (rest / length);
      length -= rest;
      rest = kSpacing;
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

double AngleTo(double from, double to) {
  return std::remainder(to - from, 2 * std::numbers::pi);
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

Result<std::vector<Waypoint>> LoadWaypoints(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot open the waypoint file"};
  std::vector<Waypoint> out;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream fields(line);
    double index = 0;
    Waypoint w;
    std::string rest;
    if (!(fields >> index >> w.position.x() >> w.position.y() >> w.yaw) || (fields >> rest) ||
        index != static_cast<double>(out.size())) {
      return Error{ErrorCode::kBadData, path + ":" + std::to_string(number) +
                                            ": want `index x y theta` with index " +
                                            std::to_string(out.size()) + ", got `" + line + "`"};
    }
    out.push_back(w);
  }
  if (out.empty()) return Error{ErrorCode::kBadData, path + ": holds no waypoint"};
  return out;
}

Result<std::vector<int>> LoadVisitOrder(const std::string& path, int num_waypoints) {
  std::ifstream in(path);
  if (!in)
    return Error{ErrorCode::kNotFound, path + ": cannot open the list of waypoints to visit"};
  std::vector<int> out;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream fields(line);
    int index = -1;
    std::string rest;
    if (!(fields >> index) || (fields >> rest) || index < 0 || index >= num_waypoints) {
      return Error{ErrorCode::kBadData,
                   path + ":" + std::to_string(number) + ": want the index of a waypoint, 0 to " +
                       std::to_string(num_waypoints - 1) + ", got `" + line + "`"};
    }
    out.push_back(index);
  }
  if (out.empty()) return Error{ErrorCode::kBadData, path + ": visits nothing"};
  return out;
}

PathFollower::PathFollower(std::vector<Waypoint> visit, std::vector<Leg> legs,
                           const FollowerConfig& config)
    : visit_(std::move(visit)), legs_(std::move(legs)), config_(config) {}

PathFollower::Output PathFollower::Update(double time_s, const Vector2d& position, double yaw) {
  if (leg_ >= static_cast<int>(legs_.size())) return {0, 0, true};
  if (pause_until_ && time_s < *pause_until_) return {};
  if (pause_until_) {
    pause_until_.reset();
    arrived_ = false;
    turning_ = true;
    nearest_ = 0;
    if (++leg_ >= static_cast<int>(legs_.size())) return {0, 0, true};
  }
  const Leg& leg = legs_[leg_];
  const double to_end = (leg.back() - position).norm();
  if (!arrived_ && to_end < 0.08) arrived_ = true;
  if (arrived_) {
    const double error = AngleTo(yaw, visit_[leg_ + 1].yaw);
    if (!config_.turn_at_waypoints || std::abs(error) < 0.05) {
      pause_until_ = time_s + config_.pause_s;
      return {};
    }
    return {0, std::clamp(1.5 * error, -config_.max_w, config_.max_w), false};
  }
  // The nearest point of the leg, searched ahead only: ways may cross themselves.
  for (size_t i = nearest_; i < std::min(leg.size(), nearest_ + 40); ++i) {
    if ((leg[i] - position).squaredNorm() < (leg[nearest_] - position).squaredNorm()) nearest_ = i;
  }
  if ((leg[nearest_] - position).norm() > 1.0) {  // carried away: join the leg where it is nearest
    for (size_t i = 0; i < leg.size(); ++i) {
      if ((leg[i] - position).squaredNorm() < (leg[nearest_] - position).squaredNorm())
        nearest_ = i;
    }
  }
  size_t target = nearest_;
  while (target + 1 < leg.size() && (leg[target] - position).norm() < config_.look_ahead_m) {
    ++target;
  }
  const Vector2d d = leg[target] - position;
  const double bearing = AngleTo(yaw, std::atan2(d.y(), d.x()));
  if (turning_ || std::abs(bearing) > 1.2) {
    turning_ = std::abs(bearing) > 0.15;
    return {0, std::clamp(1.5 * bearing, -config_.max_w, config_.max_w), false};
  }
  const double curvature = 2 * std::sin(bearing) / std::max(0.1, d.norm());
  double v = config_.max_v / (1 + 0.8 * std::abs(curvature));
  v = std::min(v, 0.08 + 0.9 * to_end);
  double w = v * curvature;
  if (std::abs(w) > config_.max_w) {
    v *= config_.max_w / std::abs(w);
    w = std::copysign(config_.max_w, w);
  }
  return {v, w, false};
}

}  // namespace gw::sim

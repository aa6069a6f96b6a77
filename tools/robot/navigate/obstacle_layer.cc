#include "tools/robot/navigate/obstacle_layer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gw::navigate {

using Eigen::Vector2d;
using Eigen::Vector2i;
using floorplan::FloorMap;

ObstacleLayer::ObstacleLayer(const FloorMap& map, double known_m)
    : known_m_(known_m),
      map_(map),
      distance_(floorplan::DistanceToOccupied(map, 2 * known_m + map.resolution)),
      remembered_(map.occupied.size(), 0) {}

void ObstacleLayer::SetMap(const FloorMap& map) {
  const FloorMap before = std::exchange(map_, map);
  distance_ = floorplan::DistanceToOccupied(map_, 2 * known_m_ + map_.resolution);
  const std::vector<uint8_t> marks =
      std::exchange(remembered_, std::vector<uint8_t>(map_.occupied.size(), 0));
  for (size_t i = 0; i < marks.size(); ++i) {
    if (marks[i] == 0) continue;
    const int cell = static_cast<int>(i);
    const Vector2i at = map_.CellOf(before.CentreOf(cell % before.width, cell / before.width));
    if (map_.InMap(at.x(), at.y())) remembered_[map_.index(at.x(), at.y())] = 1;
  }
  std::erase_if(obstacles_, [this](const Vector2d& p) {
    const Vector2i at = map_.CellOf(p);
    return !map_.InMap(at.x(), at.y()) || floorplan::DistanceAt(map_, distance_, p) < known_m_;
  });
}

void ObstacleLayer::See(const ObstacleView& view, const RobotPose& at) {
  view_utime_ = view.utime;
  half_cell_m_ = 0.5 * view.cell_m;
  seen_ahead_m_ = view.seen_ahead_m;
  obstacles_.clear();
  const Eigen::Rotation2Dd R_MB(at.yaw);
  for (const Eigen::Vector2f& p_B : view.obstacles) {
    const Vector2d p = at.position + R_MB * p_B.cast<double>();
    const Eigen::Vector2i cell = map_.CellOf(p);
    if (!map_.InMap(cell.x(), cell.y())) continue;
    if (floorplan::DistanceAt(map_, distance_, p) >= known_m_) obstacles_.push_back(p);
  }
}

std::optional<double> ObstacleLayer::SeenAhead(Utime now) const {
  if (!view_utime_) return std::nullopt;
  return now - *view_utime_ > kStale ? 0 : seen_ahead_m_;
}

double ObstacleLayer::DistanceTo(const Vector2d& p, double limit) const {
  const double farthest = limit + half_cell_m_;
  double least = farthest * farthest;
  for (const Vector2d& o : obstacles_) least = std::min(least, (o - p).squaredNorm());
  return std::max(0.0, std::sqrt(least) - half_cell_m_);
}

std::optional<size_t> ObstacleLayer::FirstBlocked(const floorplan::Leg& leg, size_t begin,
                                                  size_t points, double radius) const {
  if (obstacles_.empty()) return std::nullopt;
  for (size_t i = begin; i < std::min(leg.size(), begin + points); ++i) {
    if (DistanceTo(leg[i], radius) < radius) return i;
  }
  return std::nullopt;
}

FloorMap ObstacleLayer::On(const FloorMap& map) const {
  FloorMap out = map;
  for (size_t i = 0; i < remembered_.size(); ++i) out.occupied[i] |= remembered_[i];
  for (const Vector2d& o : obstacles_) {
    const Eigen::Vector2i cell = map.CellOf(o);
    out.occupied[map.index(cell.x(), cell.y())] = 1;
  }
  return out;
}

void ObstacleLayer::Remember() {
  for (const Vector2d& o : obstacles_) {
    const Eigen::Vector2i cell = map_.CellOf(o);
    remembered_[map_.index(cell.x(), cell.y())] = 1;
  }
}

void ObstacleLayer::Forget() {
  std::fill(remembered_.begin(), remembered_.end(), 0);
}

}  // namespace gw::navigate

#include "tools/robot/explore/sight_rays.h"

#include <algorithm>
#include <cmath>

#include "tools/robot/floorplan/pursuit.h"

namespace gw::explore {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr int kRays = 36;

}  // namespace

SightRays::Kind SightRays::KindOf(const Vector2i& cell) const {
  if (!map_.InMap(cell.x(), cell.y())) return Kind::kOpen;
  const int index = map_.index(cell.x(), cell.y());
  if (open_[index] != 0) return Kind::kOpen;
  return map_.occupied[index] != 0 || map_.Unknown(cell.x(), cell.y()) ? Kind::kEnd : Kind::kFree;
}

double SightRays::UnseenFrom(const floorplan::Waypoint& place) const {
  const double step = map_.resolution;
  const double angle = 2 * sight_.half_angle / kRays;
  double area = 0;
  for (int ray = 0; ray < kRays; ++ray) {
    const double yaw = place.yaw - sight_.half_angle + (ray + 0.5) * angle;
    const Vector2d direction(std::cos(yaw), std::sin(yaw));
    double farthest = sight_.max_range_m;
    bool beyond = false;
    for (double range = step; range < farthest; range += step) {
      const Vector2i cell = map_.CellOf(place.position + range * direction);
      const Kind kind = KindOf(cell);
      if (kind == Kind::kEnd || (kind == Kind::kFree && beyond)) break;
      if (kind == Kind::kFree) {
        // The range at which what follows this cell would still be seen.
        farthest = RangeLeft(sight_, looks_[map_.index(cell.x(), cell.y())]) + step;
        continue;
      }
      if (range > farthest) break;
      beyond = true;
      farthest = sight_.max_range_m;
      if (range >= sight_.min_range_m) area += range * angle * step;
    }
  }
  return area;
}

bool SightRays::LooksPast(const floorplan::Waypoint& place, const Vector2d& p) const {
  const Vector2d way = p - place.position;
  const double range = way.norm();
  const Vector2i target = map_.CellOf(p);
  const double farthest = RangeLeft(sight_, looks_[map_.index(target.x(), target.y())]);
  if (range < sight_.min_range_m || range > farthest) return false;
  const double turn = floorplan::AngleTo(place.yaw, std::atan2(way.y(), way.x()));
  if (std::abs(turn) > sight_.half_angle) return false;
  for (double r = 0; r < range; r += map_.resolution) {
    if (KindOf(map_.CellOf(place.position + r / range * way)) != Kind::kFree) return false;
  }
  return true;
}

}  // namespace gw::explore

#include "tools/robot/explore/sight_rays.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/robot/floorplan/pursuit.h"

namespace gw::explore {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr int kRays = 36;        // enough for an area
constexpr int kRaysBetween = 3;  // so that no cell falls between two; odd: those of an area too

}  // namespace

SightRays::Kind SightRays::KindOf(const Vector2i& cell, double range) const {
  const floorplan::FloorMap& map = floor_.map;
  if (!map.InMap(cell.x(), cell.y())) return Kind::kOpen;
  const int index = map.index(cell.x(), cell.y());
  if (floor_.open[index] != 0) {
    return floor_.MayShow(index, range) ? Kind::kOpen : Kind::kEnd;
  }
  return map.occupied[index] != 0 || map.Unknown(cell.x(), cell.y()) ? Kind::kEnd : Kind::kFree;
}

template <typename Take>
void SightRays::Follow(const floorplan::Waypoint& place, double turn, const Take& take) const {
  const Vector2d direction(std::cos(place.yaw + turn), std::sin(place.yaw + turn));
  bool beyond = false;
  for (int i = 1; i * floor_.map.resolution < floor_.sight.max_range_m; ++i) {
    const double range = i * floor_.map.resolution;
    const Vector2i cell = floor_.map.CellOf(place.position + range * direction);
    const Kind kind = KindOf(cell, range);
    if (kind == Kind::kEnd || (kind == Kind::kFree && beyond)) return;
    if (kind == Kind::kFree) continue;
    beyond = true;
    if (range >= floor_.sight.min_range_m && !take(cell, range)) return;
  }
}

double SightRays::UnseenFrom(const floorplan::Waypoint& place) const {
  const double angle = 2 * floor_.sight.half_angle / kRays;
  double area = 0;
  for (int ray = 0; ray < kRays; ++ray) {
    Follow(place, (ray + 0.5) * angle - floor_.sight.half_angle,
           [&](const Vector2i&, double range) {
             area += range * angle * floor_.map.resolution;
             return true;
           });
  }
  return area;
}

std::vector<Glance> SightRays::Glances(const floorplan::Waypoint& place) const {
  constexpr int kAll = kRays * kRaysBetween;
  const floorplan::FloorMap& map = floor_.map;
  std::map<int, float> glances;
  for (int ray = 0; ray < kAll; ++ray) {
    const double turn = ((ray + 0.5) * 2 / kAll - 1) * floor_.sight.half_angle;
    double last = floor_.sight.max_range_m;
    Follow(place, turn, [&](const Vector2i& cell, double range) {
      last = std::min(last, range + kGlanceM);
      if (map.InMap(cell.x(), cell.y())) {
        glances.try_emplace(map.index(cell.x(), cell.y()), static_cast<float>(range));
      }
      return range < last;
    });
  }
  std::vector<Glance> out;
  out.reserve(glances.size());
  for (const auto& [cell, range] : glances) out.push_back({cell, range});
  return out;
}

bool SightRays::Sees(const floorplan::Waypoint& place, const Vector2d& p) const {
  const Sight& sight = floor_.sight;
  const Vector2d way = p - place.position;
  const double range = way.norm();
  if (range < sight.min_range_m || range > sight.max_range_m) return false;
  const double turn = floorplan::AngleTo(place.yaw, std::atan2(way.y(), way.x()));
  if (std::abs(turn) > sight.half_angle) return false;
  for (double r = 0; r < range; r += floor_.map.resolution) {
    if (KindOf(floor_.map.CellOf(place.position + r / range * way), r) != Kind::kFree) return false;
  }
  return true;
}

}  // namespace gw::explore

#include "tools/robot/explore/vain_looks.h"

#include <algorithm>
#include <utility>

#include "tools/robot/explore/unseen_floor.h"

namespace gw::explore {
namespace {

// Cell of W of the map's first one.
Eigen::Vector2i FirstCell(const floorplan::FloorMap& map) {
  return (map.origin / map.resolution).array().round().cast<int>();
}

}  // namespace

void VainLooks::Watch(const floorplan::FloorMap& map, const std::vector<Glance>& glances,
                      Utime images_to) {
  if (images_to <= std::exchange(images_to_, images_to)) return in_view_.clear();
  const Eigen::Vector2i first = FirstCell(map);
  std::map<Cell, InView> now;
  std::vector<Glance> long_enough;
  for (const Glance& glance : glances) {
    const Cell cell(first.y() + glance.cell / map.width, first.x() + glance.cell % map.width);
    const auto before = in_view_.find(cell);
    InView view{images_to, glance.range_m};
    if (before != in_view_.end()) {
      view = {before->second.since, std::max(before->second.range_m, glance.range_m)};
    }
    now[cell] = view;
    if ((images_to - view.since).seconds() < kLongEnoughS) continue;
    long_enough.push_back({glance.cell, view.range_m});
  }
  in_view_ = std::move(now);
  Add(map, long_enough);
}

void VainLooks::Add(const floorplan::FloorMap& map, const std::vector<Glance>& glances) {
  const Eigen::Vector2i first = FirstCell(map);
  for (const Glance& glance : glances) {
    // With its neighbours, since the edge of what is seen moves by a cell from look to look.
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell cell(first.y() + glance.cell / map.width + dy,
                        first.x() + glance.cell % map.width + dx);
        float& least = least_m_.try_emplace(cell, kNeverLookedAt).first->second;
        least = std::min(least, glance.range_m);
      }
    }
  }
}

std::vector<float> VainLooks::On(const floorplan::FloorMap& map) const {
  std::vector<float> out(map.occupied.size(), kNeverLookedAt);
  const Eigen::Vector2i first = FirstCell(map);
  for (const auto& [cell, range] : least_m_) {
    const int x = cell.second - first.x(), y = cell.first - first.y();
    if (map.InMap(x, y)) out[map.index(x, y)] = range;
  }
  return out;
}

}  // namespace gw::explore

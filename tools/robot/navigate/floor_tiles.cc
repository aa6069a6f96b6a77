#include "tools/robot/navigate/floor_tiles.h"

#include <algorithm>

namespace gw::navigate {

using floorplan::FloorMap;

bool FloorTiles::Take(const GridUpdate& update) {
  bool changed = false;
  if (update.grid_session != session_ || update.cell_m != cell_m_) {
    changed = !tiles_.empty();
    tiles_.clear();
    session_ = update.grid_session;
    cell_m_ = update.cell_m;
  }
  for (const GridTile& tile : update.tiles) {
    const auto [at, is_new] = tiles_.try_emplace({tile.y, tile.x}, tile);
    if (!is_new && at->second.version >= tile.version) continue;
    at->second = tile;
    changed = true;
  }
  return changed;
}

FloorMap FloorTiles::Map() const {
  FloorMap map;
  if (tiles_.empty()) return map;
  int32_t first_x = INT32_MAX, last_x = INT32_MIN;
  for (const auto& [index, tile] : tiles_) {
    first_x = std::min(first_x, tile.x);
    last_x = std::max(last_x, tile.x);
  }
  const int32_t first_y = tiles_.begin()->first.first;
  const int32_t last_y = tiles_.rbegin()->first.first;
  map.resolution = cell_m_;
  map.width = (last_x - first_x + 1) * GridTile::kSide + 2;
  map.height = (last_y - first_y + 1) * GridTile::kSide + 2;
  map.origin =
      cell_m_ * Eigen::Vector2d(first_x * GridTile::kSide - 1, first_y * GridTile::kSide - 1);
  map.occupied.assign(static_cast<size_t>(map.width) * static_cast<size_t>(map.height), 0);
  map.unknown.assign(map.occupied.size(), 1);
  for (const auto& [index, tile] : tiles_) {
    const int32_t corner_x = (tile.x - first_x) * GridTile::kSide + 1;
    const int32_t corner_y = (tile.y - first_y) * GridTile::kSide + 1;
    for (int y = 0; y < GridTile::kSide; ++y) {
      for (int x = 0; x < GridTile::kSide; ++x) {
        const int cell = map.index(corner_x + x, corner_y + y);
        map.unknown[cell] = tile.at(x, y) == CellState::kUnknown ? 1 : 0;
        map.occupied[cell] = tile.at(x, y) == CellState::kOccupied ? 1 : 0;
      }
    }
  }
  return map;
}

}  // namespace gw::navigate

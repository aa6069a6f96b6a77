#include "grid/core/floor_image.h"

#include <algorithm>

namespace gw::grid {
namespace {

// visit(x, y, state) for every known cell, in cells of W.
template <typename Visit>
void ForEachKnown(const std::map<Index2, GridTile>& tiles, const Visit& visit) {
  for (const auto& [index, tile] : tiles) {
    for (int y = 0; y < kTileSide; ++y) {
      for (int x = 0; x < kTileSide; ++x) {
        const CellState state = tile.at(x, y);
        if (state == CellState::kUnknown) continue;
        visit(index.x * kTileSide + x, index.y * kTileSide + y, state);
      }
    }
  }
}

}  // namespace

FloorImage MakeFloorImage(const std::map<Index2, GridTile>& tiles, double cell_m) {
  FloorImage image;
  image.cell_m = cell_m;
  int32_t last_x = 0, last_y = 0;
  bool any = false;
  ForEachKnown(tiles, [&](int32_t x, int32_t y, CellState) {
    image.first_x = any ? std::min(image.first_x, x) : x;
    image.first_y = any ? std::min(image.first_y, y) : y;
    last_x = any ? std::max(last_x, x) : x;
    last_y = any ? std::max(last_y, y) : y;
    any = true;
  });
  if (!any) return image;
  image.width = last_x - image.first_x + 1;
  image.height = last_y - image.first_y + 1;
  image.cells.assign(static_cast<size_t>(image.width) * static_cast<size_t>(image.height),
                     CellState::kUnknown);
  ForEachKnown(tiles, [&](int32_t x, int32_t y, CellState state) {
    image.cells[static_cast<size_t>(y - image.first_y) * static_cast<size_t>(image.width) +
                static_cast<size_t>(x - image.first_x)] = state;
  });
  return image;
}

}  // namespace gw::grid

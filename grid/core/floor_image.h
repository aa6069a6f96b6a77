// The floor map as one rectangle of cells.
#pragma once

#include <map>
#include <vector>

#include "common/contract/grid.h"
#include "grid/core/cell_tiles.h"

namespace gw::grid {

struct FloorImage {
  double cell_m = 0;
  int32_t first_x = 0, first_y = 0;  // cells: its corner lies at (first_x, first_y) * cell_m in W
  int width = 0, height = 0;         // cells; 0: nothing is known
  std::vector<CellState> cells;      // row by row along x, the lowest y first

  CellState at(int x, int y) const {
    return cells[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

// The smallest rectangle that holds every known cell.
FloorImage MakeFloorImage(const std::map<Index2, GridTile>& tiles, double cell_m);

}  // namespace gw::grid

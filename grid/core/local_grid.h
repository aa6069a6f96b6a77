// A piece of the floor map that belongs to one keyframe and moves with it.
//
// Its cells lie on the lattice of W as W was when the piece began: as long as the map does not
// move, putting the pieces together shifts nothing.
#pragma once

#include <set>
#include <vector>

#include "common/core/ids.h"
#include "grid/core/cell_tiles.h"
#include "grid/core/pose2.h"

namespace gw::grid {

struct LocalGrid {
  Pose2 T_KL;  // the lattice in the body frame of the keyframe
  CellTiles cells;
};

// A new piece for a keyframe whose body is at T_WK.
LocalGrid BeginLocalGrid(const Pose2& T_WK, double cell_m);

// Adds the evidence of `from` to `into`, cell by cell; T_IF: the lattice of `from` in that of
// `into`.
void Merge(const CellTiles& from, const Pose2& T_IF, double cell_m, CellTiles* into);

// Tiles of W that a tile of a lattice at T_WL touches, or comes nearer to than `margin` cells.
std::set<Index2> TilesTouchedBy(Index2 tile, const Pose2& T_WL, double cell_m, int margin);

// A square of cells of W.
struct CellWindow {
  CellWindow(Index2 first_cell, int side_cells)
      : first(first_cell),
        side(side_cells),
        cells(static_cast<size_t>(side_cells) * static_cast<size_t>(side_cells)) {}
  Cell& at(int x, int y) {
    return cells[static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x)];
  }
  const Cell& at(int x, int y) const {
    return cells[static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x)];
  }

  Index2 first;
  int side;
  std::vector<Cell> cells;
};

// Adds what the cells of a lattice at T_WL say of the cells of the window.
void AddTo(CellWindow* sum, const CellTiles& cells, const Pose2& T_WL, double cell_m);

}  // namespace gw::grid

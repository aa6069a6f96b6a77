// What gw-grid says of the floor: where the robot can drive, and what is in its way.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/core/time.h"

namespace gw {

enum class CellState : uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

// A square piece of the floor map.
struct GridTile {
  static constexpr int kSide = 32;  // cells

  int32_t x = 0, y = 0;  // in tiles: its corner lies at (x, y) * kSide * cell_m in W
  int64_t version = 0;   // grid_version of the change that made it what it is
  std::array<CellState, static_cast<size_t>(kSide) * kSide> cells{};  // row by row along x of W

  CellState at(int cell_x, int cell_y) const {
    return cells[static_cast<size_t>(cell_y) * kSide + static_cast<size_t>(cell_x)];
  }
};

// Part of the floor map in W. A receiver keeps the newest version of every tile; tiles that changed
// come at once, all others come again in turn. A tile that never came is unknown.
struct GridUpdate {
  Utime utime;  // of the newest image in it
  int64_t seq = 0;
  int64_t grid_session = 0;  // start of the grid, us: when it changes, older tiles are void
  int64_t grid_version = 0;  // counts up with every change
  int64_t map_revision = 0;  // of the keyframe poses it was composed with
  double cell_m = 0;
  std::vector<GridTile> tiles;  // sorted by (y, x)
};

// Obstacles around the robot, in the body frame of `utime`: x forward, y left.
struct ObstacleView {
  Utime utime;  // of the image
  int64_t seq = 0;
  double cell_m = 0;        // each obstacle is a cell of this side around its point
  double seen_ahead_m = 0;  // so far the floor straight ahead is seen to be free, from B; 0: blind
  std::vector<Eigen::Vector2f> obstacles;  // m, nearest first
};

}  // namespace gw

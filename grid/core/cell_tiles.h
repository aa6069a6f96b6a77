// What is known of the cells of an unbounded floor: square tiles, made where something was seen.
// Tiles are visited in order of (y, x), so that results do not depend on the order of seeing.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <utility>

#include "common/contract/grid.h"

namespace gw::grid {

// Index of a cell or of a tile; ordered by y, then x.
struct Index2 {
  int32_t x = 0, y = 0;
  friend bool operator<(const Index2& a, const Index2& b) {
    return std::pair(a.y, a.x) < std::pair(b.y, b.x);
  }
  friend bool operator==(const Index2&, const Index2&) = default;
};

inline constexpr int kTileSide = GridTile::kSide;

// Rounds towards minus infinity.
constexpr int32_t TileOf(int32_t cell) {
  return cell >= 0 ? cell / kTileSide : -((kTileSide - 1 - cell) / kTileSide);
}
constexpr Index2 TileOf(Index2 cell) {
  return {TileOf(cell.x), TileOf(cell.y)};
}

// Evidence of a cell, and its bounds: what has been confirmed often still changes its mind after a
// few looks. Hornung et al., "OctoMap", Autonomous Robots 2013, section 5.1: P(hit) 0.7, P(miss)
// 0.4, bounds 0.12 and 0.97.
struct Cell {
  static constexpr float kHit = 0.85f, kMiss = -0.4f;
  static constexpr float kLeast = -2.0f, kMost = 3.5f;
  // A second of sharp looks: more does not make a wall truer than one that was seen so long.
  static constexpr float kMostSharpness = 10.0f;

  float log_odds = 0;   // of being occupied
  float sharpness = 0;  // of the hits, summed: 1 for one that tells the cell for sure

  void Add(const Cell& evidence) {
    log_odds = std::clamp(log_odds + evidence.log_odds, kLeast, kMost);
    sharpness = std::min(kMostSharpness, sharpness + evidence.sharpness);
  }
  friend bool operator==(const Cell&, const Cell&) = default;
};

class CellTiles {
 public:
  using Tile = std::array<Cell, static_cast<size_t>(kTileSide) * kTileSide>;

  void Add(Index2 cell, const Cell& evidence) { tiles_[TileOf(cell)][Offset(cell)].Add(evidence); }
  const std::map<Index2, Tile>& tiles() const { return tiles_; }
  const Tile* Find(Index2 tile) const {
    const auto found = tiles_.find(tile);
    return found == tiles_.end() ? nullptr : &found->second;
  }
  Tile& Make(Index2 tile) { return tiles_[tile]; }

  static constexpr size_t Offset(Index2 cell) {
    const auto inside = [](int32_t c) { return static_cast<size_t>(c - TileOf(c) * kTileSide); };
    return inside(cell.y) * kTileSide + inside(cell.x);
  }

 private:
  std::map<Index2, Tile> tiles_;
};

}  // namespace gw::grid

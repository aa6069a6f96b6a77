// Log-odds of occupancy on an unbounded floor: square tiles, made where something was seen. Tiles
// are visited in order of (y, x), so that results do not depend on the order of seeing.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <utility>

#include "common/contract/grid.h"

namespace gw::grid {

// Of a cell or of a tile; ordered by y, then x.
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

class CellTiles {
 public:
  using Tile = std::array<float, static_cast<size_t>(kTileSide) * kTileSide>;

  // 0 where nothing was seen.
  float at(Index2 cell) const {
    const auto tile = tiles_.find(TileOf(cell));
    return tile == tiles_.end() ? 0.0f : tile->second[Offset(cell)];
  }
  // Adds evidence and keeps the sum inside [min, max].
  void Add(Index2 cell, float evidence, float min, float max) {
    float& value = tiles_[TileOf(cell)][Offset(cell)];
    value = std::min(max, std::max(min, value + evidence));
  }
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

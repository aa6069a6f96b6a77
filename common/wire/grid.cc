#include "common/wire/grid.h"

#include <algorithm>
#include <gw_lcm/grid_t.hpp>
#include <gw_lcm/obstacles_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
namespace {

constexpr size_t kMaxTiles = 1 << 16;      // 168 x 168 m of cells of 2 cm, in one message
constexpr size_t kMaxObstacles = 1 << 16;  // cells in sight
constexpr int32_t kMaxTileIndex = 1 << 20;
constexpr double kLeastCell = 1e-3, kMostCell = 10;  // m
constexpr double kFar = 1e6;                         // m
constexpr size_t kTileBytes = 16 + std::tuple_size_v<decltype(GridTile::cells)>;
constexpr size_t kObstacleBytes = 8;
constexpr int kLastState = static_cast<int>(CellState::kOccupied);
static_assert(gw_lcm::grid_tile_t::CELL_FREE == static_cast<int>(CellState::kFree));
static_assert(gw_lcm::grid_tile_t::CELL_OCCUPIED == kLastState);

void State(Writer& a, CellState state) {
  a.Byte("tiles.cell_states", static_cast<uint8_t>(state), kLastState);
}
void State(Reader& a, CellState& state) {
  uint8_t number = 0;
  a.Byte("tiles.cell_states", number, kLastState);
  state = static_cast<CellState>(number);
}

}  // namespace

template <typename A>
static void Fields(A& a, typename A::template Of<GridUpdate>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Duration("grid_session", m.grid_session);
  Seq(a, "grid_version", m.grid_version);
  Seq(a, "map_revision", m.map_revision);
  a.Real("cell_m", m.cell_m, kLeastCell, kMostCell);
  a.List("tiles", m.tiles, kMaxTiles, kTileBytes, [](A& each, auto& tile) {
    each.Int32("tiles.tile_x", tile.x, -kMaxTileIndex, kMaxTileIndex);
    each.Int32("tiles.tile_y", tile.y, -kMaxTileIndex, kMaxTileIndex);
    Seq(each, "tiles.tile_version", tile.version);
    for (auto& cell : tile.cells) State(each, cell);
  });
  a.Rule("tiles", "not sorted, or has one twice",
         std::adjacent_find(m.tiles.begin(), m.tiles.end(),
                            [](const GridTile& left, const GridTile& right) {
                              return std::pair(left.y, left.x) >= std::pair(right.y, right.x);
                            }) == m.tiles.end());
}

template <typename A>
static void Fields(A& a, typename A::template Of<ObstacleView>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Real("cell_m", m.cell_m, kLeastCell, kMostCell);
  a.Real("seen_ahead_m", m.seen_ahead_m, 0, kFar);
  a.List("obstacles", m.obstacles, kMaxObstacles, kObstacleBytes, [](A& each, auto& p_B) {
    each.Real32("obstacles.x_B_m", p_B.x());
    each.Real32("obstacles.y_B_m", p_B.y());
  });
}

Bytes Encode(const GridUpdate& update) {
  return EncodeFields(gw_lcm::grid_t::getHash(), update);
}
template <>
Result<GridUpdate> Decode(ByteSpan message) {
  return DecodeFields<GridUpdate>("grid_t", gw_lcm::grid_t::getHash(), message);
}

Bytes Encode(const ObstacleView& view) {
  return EncodeFields(gw_lcm::obstacles_t::getHash(), view);
}
template <>
Result<ObstacleView> Decode(ByteSpan message) {
  return DecodeFields<ObstacleView>("obstacles_t", gw_lcm::obstacles_t::getHash(), message);
}

}  // namespace gw::wire

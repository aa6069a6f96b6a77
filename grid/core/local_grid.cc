#include "grid/core/local_grid.h"

#include <algorithm>
#include <cmath>

namespace gw::grid {
namespace {

// Cells of one lattice at the centres of another's: both in units of cells.
class CellMap {
 public:
  // T_FI: the lattice of the asking cells in that of the asked ones.
  CellMap(const Pose2& T_FI, double cell_m)
      : origin_(T_FI * Eigen::Vector2d(cell_m / 2, cell_m / 2) / cell_m),
        x_(T_FI.Rotate({1, 0})),
        y_(T_FI.Rotate({0, 1})) {}

  Index2 At(int32_t x, int32_t y) const {
    const Eigen::Vector2d p = origin_ + x * x_ + y * y_;
    // A lattice that has not moved differs by rounding alone; its centres stay inside their cells.
    return {static_cast<int32_t>(std::floor(p.x())), static_cast<int32_t>(std::floor(p.y()))};
  }

 private:
  Eigen::Vector2d origin_, x_, y_;
};

}  // namespace

LocalGrid BeginLocalGrid(const Pose2& T_WK, double cell_m) {
  // Close to the keyframe, so that a turn of the keyframe moves the cells little against it.
  const Eigen::Vector2d corner = (T_WK.translation() / cell_m).array().floor().matrix() * cell_m;
  return {T_WK.inverse() * Pose2(corner, 0), {}};
}

void Merge(const CellTiles& from, const Pose2& T_IF, double cell_m, CellTiles* into) {
  std::set<Index2> targets;
  for (const auto& [tile, cells] : from.tiles()) {
    targets.merge(TilesTouchedBy(tile, T_IF, cell_m, 0));
  }
  for (const Index2 tile : targets) {
    CellWindow window({tile.x * kTileSide, tile.y * kTileSide}, kTileSide);
    AddTo(&window, from, T_IF, cell_m);
    CellTiles::Tile& target = into->Make(tile);
    for (size_t i = 0; i < target.size(); ++i) target[i].Add(window.cells[i]);
  }
}

std::set<Index2> TilesTouchedBy(Index2 tile, const Pose2& T_WL, double cell_m, int margin) {
  const double side = kTileSide * cell_m;
  Eigen::Array2d least = Eigen::Array2d::Constant(1e18), most = -least;
  for (const double dx : {0.0, 1.0}) {
    for (const double dy : {0.0, 1.0}) {
      const Eigen::Array2d p =
          (T_WL * (side * Eigen::Vector2d(tile.x + dx, tile.y + dy))).array() / side;
      least = least.min(p);
      most = most.max(p);
    }
  }
  // Without the neighbours that are touched by rounding alone.
  const double inside = 1e-6 - static_cast<double>(margin) / kTileSide;
  std::set<Index2> out;
  const auto first = [inside](double p) { return static_cast<int32_t>(std::floor(p + inside)); };
  const auto last = [inside](double p) { return static_cast<int32_t>(std::ceil(p - inside)) - 1; };
  for (int32_t y = first(least.y()); y <= last(most.y()); ++y) {
    for (int32_t x = first(least.x()); x <= last(most.x()); ++x) out.insert({x, y});
  }
  return out;
}

void AddTo(CellWindow* sum, const CellTiles& cells, const Pose2& T_WL, double cell_m) {
  const CellMap map(T_WL.inverse(), cell_m);
  // Neighbouring cells lie in the same tile nearly always: look it up only when it changes.
  Index2 known{};
  const CellTiles::Tile* source = cells.Find(known);
  for (int y = 0; y < sum->side; ++y) {
    for (int x = 0; x < sum->side; ++x) {
      const Index2 cell = map.At(sum->first.x + x, sum->first.y + y);
      if (const Index2 now = TileOf(cell); !(now == known)) {
        known = now;
        source = cells.Find(known);
      }
      if (source != nullptr) sum->at(x, y).Add((*source)[CellTiles::Offset(cell)]);
    }
  }
}

}  // namespace gw::grid

// An explorer that drives a simulated base on true poses and sees the floor without noise, for the
// tests of this folder. W is the frame of the building's plan.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/robot/navigate/explorer.h"
#include "tools/robot/navigate/test_base.h"

namespace gw::navigate {

class TestExploration : public TestBase {
 public:
  static constexpr double kCell = 0.05;  // m

  TestExploration(floorplan::FloorMap world, const floorplan::Waypoint& start,
                  const explore::Sight& sight = {0.69, 0.6, 3.0})
      : TestBase(std::move(world), start), explorer(NavigateConfig{}, sight), sight_(sight) {}

  Explorer explorer;
  bool grid_comes = true;
  // Vision does not know the place here: no image is added to the floor map.
  std::function<bool(const Eigen::Vector2d& p)> blind = [](const Eigen::Vector2d&) {
    return false;
  };
  // What of the world the robot does not see, as glass; it can touch it.
  std::function<bool(const Eigen::Vector2d& p)> invisible = [](const Eigen::Vector2d&) {
    return false;
  };
  // Was the robot's centre ever where its map did not know the floor to be free?
  bool entered_unknown() const { return entered_unknown_; }

 private:
  using Cell = std::pair<int, int>;      // y, x in W
  static constexpr double kSeam = 0.07;  // m before an obstacle no floor is seen

  static Cell CellOf(const Eigen::Vector2d& p) {
    return {static_cast<int>(std::floor(p.y() / kCell)),
            static_cast<int>(std::floor(p.x() / kCell))};
  }
  void Mark(const Eigen::Vector2d& p, CellState state) {
    if (blind(base().position())) return;
    CellState& cell = cells_[CellOf(p)];
    if (cell != CellState::kOccupied) cell = state;
  }

  ObstacleView See(Utime now) {
    ObstacleView out;
    out.utime = now;
    out.cell_m = kCell;
    if (!blind(base().position())) image_ = now;
    const Eigen::Rotation2Dd R_WB(base().yaw());
    for (double x = -0.15; x <= 0.15; x += kCell) {
      for (double y = -0.15; y <= 0.15; y += kCell) {
        if (std::hypot(x, y) > 0.17) continue;
        Mark(base().position() + Eigen::Vector2d(x, y), CellState::kFree);
      }
    }
    constexpr int kRays = 240;
    for (int ray = 0; ray < kRays; ++ray) {
      const double yaw = base().yaw() + sight_.half_angle * (2.0 * ray / (kRays - 1) - 1);
      const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
      double range = 0;
      bool hit = false;
      for (; !hit && range < sight_.max_range_m; range += 0.02) {
        const Eigen::Vector2d p = base().position() + range * direction;
        const Eigen::Vector2i cell = world().CellOf(p);
        hit = world().Occupied(cell.x(), cell.y()) && !invisible(p);
      }
      const double free_to = range - (hit ? kSeam : 0);
      for (double r = sight_.min_range_m; r < free_to; r += 0.02) {
        Mark(base().position() + r * direction, CellState::kFree);
      }
      if (hit) {
        const Eigen::Vector2d p = base().position() + (range + 0.005) * direction;
        Mark(p, CellState::kOccupied);
        out.obstacles.push_back((R_WB.inverse() * (p - base().position())).cast<float>());
      }
      if (ray == kRays / 2) out.seen_ahead_m = range;
    }
    return out;
  }

  void SendGrid(Utime now) {
    std::map<std::pair<int, int>, GridTile> tiles;
    const auto tile_of = [](int cell) {
      return static_cast<int>(std::floor(cell / static_cast<double>(GridTile::kSide)));
    };
    GridUpdate update;
    update.utime = image_;
    update.grid_session = 1;
    update.grid_version = ++version_;
    update.cell_m = kCell;
    for (const auto& [cell, state] : cells_) {
      const std::pair<int, int> at(tile_of(cell.first), tile_of(cell.second));
      GridTile& tile = tiles[at];
      tile.y = at.first;
      tile.x = at.second;
      tile.version = version_;
      const int y = cell.first - at.first * GridTile::kSide;
      const int x = cell.second - at.second * GridTile::kSide;
      tile.cells[static_cast<size_t>(y) * GridTile::kSide + static_cast<size_t>(x)] = state;
    }
    for (const auto& [at, tile] : tiles) update.tiles.push_back(tile);
    explorer.Take(update, now);
  }

  Driver& driver() override { return explorer; }
  void Look(Utime now) override {
    explorer.See(See(now));
    if (now.us % 500'000 == 0 && grid_comes) SendGrid(now);
    const floorplan::FloorMap& map = explorer.map();
    if (map.occupied.empty()) return;
    const Eigen::Vector2i cell = map.CellOf(base().position());
    entered_unknown_ = entered_unknown_ || map.Unknown(cell.x(), cell.y());
  }

  explore::Sight sight_;
  std::map<Cell, CellState> cells_;
  Utime image_;  // that was added last
  int64_t version_ = 0;
  bool entered_unknown_ = false;
};

}  // namespace gw::navigate

// An explorer that drives a simulated base on true poses and sees the floor without noise, for the
// tests of this folder. W is the frame of the building's plan.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "drivers/kobuki/core/safety_guard.h"
#include "tools/robot/navigate/explorer.h"
#include "tools/sim/sim/base.h"

namespace gw::navigate {

class TestExploration {
 public:
  static constexpr double kCell = 0.05;  // m

  TestExploration(floorplan::FloorMap world, const floorplan::Waypoint& start,
                  const explore::Sight& sight = {0.69, 0.6, 3.0})
      : explorer(NavigateConfig{}, sight),
        world_(std::move(world)),
        sight_(sight),
        distance_(floorplan::DistanceToOccupied(world_, 2)),
        base_({}, world_, distance_, 1) {
    base_.Place(start.position, start.yaw);
  }

  Explorer explorer;
  bool grid_comes = true;
  std::vector<Event> events;
  double way_m = 0;

  void RunUntil(double t) {
    while (seconds() < t && !explorer.finished()) Step();
  }
  double seconds() const { return static_cast<double>(ms_) * 1e-3; }
  bool bumped() const { return bumped_; }
  const sim::Base& base() const { return base_; }
  // Was the robot's centre ever where its map did not know the floor to be free?
  bool entered_unknown() const { return entered_unknown_; }
  int Count(EventKind kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [kind](const Event& e) { return e.kind == kind; }));
  }

 private:
  using Cell = std::pair<int, int>;      // y, x in W
  static constexpr double kSeam = 0.07;  // m before an obstacle no floor is seen

  static Cell CellOf(const Eigen::Vector2d& p) {
    return {static_cast<int>(std::floor(p.y() / kCell)),
            static_cast<int>(std::floor(p.x() / kCell))};
  }
  void Mark(const Eigen::Vector2d& p, CellState state) {
    CellState& cell = cells_[CellOf(p)];
    if (cell != CellState::kOccupied) cell = state;
  }

  ObstacleView Look(Utime now) {
    ObstacleView out;
    out.utime = now;
    out.cell_m = kCell;
    const Eigen::Rotation2Dd R_WB(base_.yaw());
    for (double x = -0.15; x <= 0.15; x += kCell) {
      for (double y = -0.15; y <= 0.15; y += kCell) {
        if (std::hypot(x, y) > 0.17) continue;
        Mark(base_.position() + Eigen::Vector2d(x, y), CellState::kFree);
      }
    }
    constexpr int kRays = 240;
    for (int ray = 0; ray < kRays; ++ray) {
      const double yaw = base_.yaw() + sight_.half_angle * (2.0 * ray / (kRays - 1) - 1);
      const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
      double range = 0;
      bool hit = false;
      for (; !hit && range < sight_.max_range_m; range += 0.02) {
        const Eigen::Vector2i cell = world_.CellOf(base_.position() + range * direction);
        hit = world_.Occupied(cell.x(), cell.y());
      }
      const double free_to = range - (hit ? kSeam : 0);
      for (double r = sight_.min_range_m; r < free_to; r += 0.02) {
        Mark(base_.position() + r * direction, CellState::kFree);
      }
      if (hit) {
        const Eigen::Vector2d p = base_.position() + (range + 0.005) * direction;
        Mark(p, CellState::kOccupied);
        out.obstacles.push_back((R_WB.inverse() * (p - base_.position())).cast<float>());
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
    update.utime = now;
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

  void Step() {
    const Utime now{ms_ * 1000};
    if (ms_ % 10 == 0) explorer.Push(RobotPose{now, base_.position(), base_.yaw(), 0, 0});
    if (ms_ % 100 == 0) explorer.See(Look(now));
    if (ms_ % 500 == 0 && grid_comes) SendGrid(now);
    if (ms_ % 20 == 0) {
      ContactFlags contact;
      contact.bumper = base_.bumper();
      bumped_ = bumped_ || contact.bumper;
      explorer.Sense(contact);
      guard_.Sense(contact, now);
    }
    if (ms_ % (1000 / Driver::kRateHz) == 0) {
      const Driver::Output out = explorer.Update(now);
      events.insert(events.end(), out.events.begin(), out.events.end());
      const kobuki::Twist allowed = guard_.Filter({out.speed.v, out.speed.w}, now);
      base_.Command(seconds(), allowed.v_m_s, allowed.w_rad_s);
      const floorplan::FloorMap& map = explorer.map();
      const Eigen::Vector2i cell = map.CellOf(base_.position());
      if (!map.occupied.empty() && map.Unknown(cell.x(), cell.y())) {
        if (!entered_unknown_)
          std::printf("unknown at %.2f s (%.2f, %.2f) w=%d\n", seconds(), base_.position().x(),
                      base_.position().y(), map.width);
        entered_unknown_ = true;
      }
    }
    const Eigen::Vector2d before = base_.position();
    base_.Step(seconds(), 1e-3, {});
    way_m += (base_.position() - before).norm();
    ++ms_;
  }

  floorplan::FloorMap world_;
  explore::Sight sight_;
  std::vector<float> distance_;
  sim::Base base_;
  kobuki::SafetyGuard guard_;
  std::map<Cell, CellState> cells_;
  int64_t version_ = 0;
  bool bumped_ = false, entered_unknown_ = false;
  int64_t ms_ = 0;
};

}  // namespace gw::navigate

// A navigator that drives a simulated base on true poses, for the tests of this folder.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "tools/robot/navigate/navigator.h"
#include "tools/robot/navigate/test_base.h"

namespace gw::navigate {

class TestDrive : public TestBase {
 public:
  // world: what is really there; the navigator knows its own map. begins_looking: it looks at the
  // world, ten times a second, as gw-grid does.
  TestDrive(Navigator navigator, floorplan::FloorMap world, const floorplan::Waypoint& start,
            bool begins_looking = false)
      : TestBase(std::move(world), start),
        looks(begins_looking),
        navigator_(std::move(navigator)) {}

  bool looks;
  std::function<bool(double t)> blind = [](double) { return false; };

  const Navigator& navigator() const { return navigator_; }
  // For something that comes or goes. Precondition: cell in the world.
  void SetOccupied(const Eigen::Vector2i& cell, bool occupied) { SetWorld(cell, occupied); }

 private:
  static constexpr double kViewHalfAngle = 0.69;  // rad, as of a D435i
  static constexpr double kViewRange = 3;         // m
  static constexpr double kMemory = 10;           // s

  // The first occupied cell of every ray, and how far the floor straight ahead is free.
  ObstacleView LookAround(Utime now) {
    ObstacleView out;
    out.utime = now;
    out.cell_m = world().resolution;
    const int rays = blind(seconds()) ? 0 : 139;
    for (int ray = 0; ray < rays; ++ray) {
      const double yaw = base().yaw() - kViewHalfAngle + 2 * kViewHalfAngle * ray / (rays - 1);
      const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
      double range = 0;
      for (bool free = true; free && range < kViewRange; range += 0.02) {
        const Eigen::Vector2i cell = world().CellOf(base().position() + range * direction);
        free = !world().Occupied(cell.x(), cell.y());
        if (!free) seen_[world().index(cell.x(), cell.y())] = seconds();
      }
      if (ray == rays / 2) out.seen_ahead_m = range;
    }
    std::erase_if(seen_, [this](const auto& cell) {
      return seconds() - cell.second > kMemory || world().occupied[cell.first] == 0;
    });
    const Eigen::Rotation2Dd R_BM(-base().yaw());
    for (const auto& [index, t] : seen_) {
      const Eigen::Vector2d p = world().CentreOf(index % world().width, index / world().width);
      out.obstacles.push_back((R_BM * (p - base().position())).cast<float>());
    }
    return out;
  }

  Driver& driver() override { return navigator_; }
  void Look(Utime now) override {
    if (looks) navigator_.See(LookAround(now));
  }

  Navigator navigator_;
  std::map<int, double> seen_;  // cell of the world, when
};

}  // namespace gw::navigate

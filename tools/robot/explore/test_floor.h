// Floor plans for tests, and what a robot without noise has seen of one.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "tools/robot/explore/sight.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::explore {

// As of a D435i at the height of a TurtleBot, range 4 m.
inline constexpr Sight kTestSight{0.72, 0.4, 3.0};

// Fills a rectangle of a plan; metres.
inline void Fill(double x0, double y0, double x1, double y1, uint8_t occupied,
                 floorplan::FloorMap* plan) {
  for (int y = 0; y < plan->height; ++y) {
    for (int x = 0; x < plan->width; ++x) {
      const Eigen::Vector2d p = plan->CentreOf(x, y);
      if (p.x() > x0 && p.x() < x1 && p.y() > y0 && p.y() < y1) {
        plan->occupied[plan->index(x, y)] = occupied;
      }
    }
  }
}

// Free floor between walls of 0.1 m, cells of 0.05 m, the corner at (0, 0).
inline floorplan::FloorMap TestRoom(double width_m, double height_m) {
  floorplan::FloorMap plan;
  plan.resolution = 0.05;
  plan.width = static_cast<int>(std::lround(width_m / plan.resolution));
  plan.height = static_cast<int>(std::lround(height_m / plan.resolution));
  plan.occupied.assign(static_cast<size_t>(plan.width) * static_cast<size_t>(plan.height), 1);
  Fill(0.1, 0.1, width_m - 0.1, height_m - 0.1, 0, &plan);
  return plan;
}

// A room of 4 x 4 m at either side of a wall at x = 4 with a door of this width at y = 2.
inline floorplan::FloorMap TwoRooms(double door_m) {
  floorplan::FloorMap plan = TestRoom(8.1, 4);
  Fill(4, 0, 4.1, 4, 1, &plan);
  Fill(4, 2 - 0.5 * door_m, 4.1, 2 + 0.5 * door_m, 0, &plan);
  return plan;
}

// The part of a plan that was seen.
class SeenFloor {
 public:
  explicit SeenFloor(floorplan::FloorMap plan) : plan_(std::move(plan)), map_(plan_) {
    map_.occupied.assign(plan_.occupied.size(), 0);
    map_.unknown.assign(plan_.occupied.size(), 1);
  }

  const floorplan::FloorMap& map() const { return map_; }

  // A third farther than the sight is relied upon, as gw-grid sees.
  void Look(const floorplan::Waypoint& from, const Sight& sight) {
    const int rays = 400;
    for (int ray = 0; ray <= rays; ++ray) {
      const double yaw = from.yaw + sight.half_angle * (2.0 * ray / rays - 1);
      const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
      for (double range = 0; range < sight.max_range_m / 0.75; range += 0.01) {
        const Eigen::Vector2i cell = plan_.CellOf(from.position + range * direction);
        if (!plan_.InMap(cell.x(), cell.y())) break;
        if (range >= sight.min_range_m) Reveal(cell.x(), cell.y());
        if (plan_.Occupied(cell.x(), cell.y())) break;
      }
    }
  }

  // The floor under the robot.
  void Cover(const Eigen::Vector2d& centre, double radius) {
    for (int y = 0; y < plan_.height; ++y) {
      for (int x = 0; x < plan_.width; ++x) {
        if ((plan_.CentreOf(x, y) - centre).norm() <= radius) Reveal(x, y);
      }
    }
  }

  void LookAround(const Eigen::Vector2d& from, const Sight& sight) {
    for (int i = 0; i < 8; ++i) Look({from, 0.25 * std::numbers::pi * i}, sight);
  }

 private:
  void Reveal(int x, int y) {
    map_.unknown[map_.index(x, y)] = 0;
    map_.occupied[map_.index(x, y)] = plan_.occupied[plan_.index(x, y)];
  }

  floorplan::FloorMap plan_, map_;
};

}  // namespace gw::explore

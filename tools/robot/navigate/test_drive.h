// A navigator that drives a simulated base on true poses, for the tests of this folder.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "drivers/kobuki/core/safety_guard.h"
#include "tools/robot/navigate/navigator.h"
#include "tools/sim/sim/base.h"

namespace gw::navigate {

class TestDrive {
 public:
  // world: what is really there; the navigator knows its own map. begins_looking: it looks at the
  // world, ten times a second, as gw-grid does.
  TestDrive(Navigator navigator, floorplan::FloorMap world, const floorplan::Waypoint& start,
            bool begins_looking = false)
      : looks(begins_looking),
        navigator_(std::move(navigator)),
        world_(std::move(world)),
        distance_(floorplan::DistanceToOccupied(world_, 2)),
        base_({}, world_, distance_, 1) {
    base_.Place(start.position, start.yaw);
  }

  // What the navigator is told of the truth; empty: nothing new.
  std::function<std::optional<RobotPose>(const RobotPose& truth)> view =
      [](const RobotPose& truth) { return truth; };
  bool looks;
  std::function<bool(double t)> blind = [](double) { return false; };
  std::function<ContactFlags(double t)> extra_contact = [](double) { return ContactFlags{}; };

  // Until it is finished or t seconds have passed since the begin.
  void RunUntil(double t) {
    while (seconds() < t && !navigator_.finished()) Step();
  }

  double seconds() const { return static_cast<double>(ms_) * 1e-3; }
  const sim::Base& base() const { return base_; }
  const Navigator& navigator() const { return navigator_; }
  bool bumped() const { return bumped_; }
  // For something that comes or goes. Precondition: cell in the world.
  void SetOccupied(const Eigen::Vector2i& cell, bool occupied) {
    world_.occupied[world_.index(cell.x(), cell.y())] = occupied ? 1 : 0;
    distance_ = floorplan::DistanceToOccupied(world_, 2);
  }
  const floorplan::Speed& command() const { return command_; }
  int Count(EventKind kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [kind](const Event& e) { return e.kind == kind; }));
  }

  std::vector<Event> events;
  std::vector<RobotPose> truth_at_events;

 private:
  static constexpr double kViewHalfAngle = 0.69;  // rad, as of a D435i
  static constexpr double kViewRange = 3;         // m
  static constexpr double kMemory = 10;           // s

  // The first occupied cell of every ray, and how far the floor straight ahead is free.
  ObstacleView LookAround(Utime now) {
    ObstacleView out;
    out.utime = now;
    out.cell_m = world_.resolution;
    const int rays = blind(seconds()) ? 0 : 139;
    for (int ray = 0; ray < rays; ++ray) {
      const double yaw = base_.yaw() - kViewHalfAngle + 2 * kViewHalfAngle * ray / (rays - 1);
      const Eigen::Vector2d direction(std::cos(yaw), std::sin(yaw));
      double range = 0;
      for (bool free = true; free && range < kViewRange; range += 0.02) {
        const Eigen::Vector2i cell = world_.CellOf(base_.position() + range * direction);
        free = !world_.Occupied(cell.x(), cell.y());
        if (!free) seen_[world_.index(cell.x(), cell.y())] = seconds();
      }
      if (ray == rays / 2) out.seen_ahead_m = range;
    }
    std::erase_if(seen_, [this](const auto& cell) {
      return seconds() - cell.second > kMemory || world_.occupied[cell.first] == 0;
    });
    const Eigen::Rotation2Dd R_BM(-base_.yaw());
    for (const auto& [index, t] : seen_) {
      const Eigen::Vector2d p = world_.CentreOf(index % world_.width, index / world_.width);
      out.obstacles.push_back((R_BM * (p - base_.position())).cast<float>());
    }
    return out;
  }

  void Step() {
    const Utime now{ms_ * 1000};
    if (ms_ % 10 == 0) {
      truth_ = {now, base_.position(), base_.yaw(), 0, 0};
      if (const auto seen = view(truth_)) navigator_.Push(seen);
    }
    if (looks && ms_ % 100 == 0) navigator_.See(LookAround(now));
    if (ms_ % 20 == 0) {
      ContactFlags contact = extra_contact(seconds());
      contact.bumper = contact.bumper || base_.bumper();
      bumped_ = bumped_ || base_.bumper();
      navigator_.Sense(contact);
      guard_.Sense(contact, now);
    }
    if (ms_ % (1000 / Navigator::kRateHz) == 0) {
      const Navigator::Output out = navigator_.Update(now);
      command_ = out.speed;
      for (const Event& event : out.events) {
        events.push_back(event);
        truth_at_events.push_back(truth_);
      }
      const kobuki::Twist allowed = guard_.Filter({command_.v, command_.w}, now);
      base_.Command(seconds(), allowed.v_m_s, allowed.w_rad_s);
    }
    base_.Step(seconds(), 1e-3, {});
    ++ms_;
  }

  Navigator navigator_;
  floorplan::FloorMap world_;
  std::vector<float> distance_;
  sim::Base base_;
  kobuki::SafetyGuard guard_;
  RobotPose truth_;
  floorplan::Speed command_;
  std::map<int, double> seen_;  // cell of the world, when
  bool bumped_ = false;
  int64_t ms_ = 0;
};

}  // namespace gw::navigate

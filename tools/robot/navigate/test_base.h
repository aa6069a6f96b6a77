// A simulated base in a building, and the Driver of this folder that drives it: true poses (or what
// a test makes of them) and contacts to the driver, its commands to the base, as live through the
// guard of the base's driver.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/kobuki/core/safety_guard.h"
#include "tools/robot/navigate/driver.h"
#include "tools/sim/sim/base.h"

namespace gw::navigate {

class TestBase {
 public:
  TestBase(floorplan::FloorMap world, const floorplan::Waypoint& start)
      : world_(std::move(world)),
        distance_(floorplan::DistanceToOccupied(world_, 2)),
        base_({}, world_, distance_, 1) {
    base_.Place(start.position, start.yaw);
  }
  virtual ~TestBase() = default;

  // What the driver is told of the truth; empty: nothing new.
  std::function<std::optional<RobotPose>(const RobotPose& truth)> view =
      [](const RobotPose& truth) { return truth; };
  std::function<ContactFlags(double t)> extra_contact = [](double) { return ContactFlags{}; };

  // Until it is finished or t seconds have passed since the begin.
  void RunUntil(double t) {
    while (seconds() < t && !driver().finished()) Step();
  }

  double seconds() const { return static_cast<double>(ms_) * 1e-3; }
  double way_m() const { return way_m_; }
  const sim::Base& base() const { return base_; }
  bool bumped() const { return bumped_; }
  const floorplan::Speed& command() const { return command_; }
  int Count(EventKind kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [kind](const Event& e) { return e.kind == kind; }));
  }

  std::vector<Event> events;
  std::vector<RobotPose> truth_at_events;

 protected:
  virtual Driver& driver() = 0;
  // What it sees, ten times a second.
  virtual void Look(Utime now) = 0;

  const floorplan::FloorMap& world() const { return world_; }
  void SetWorld(const Eigen::Vector2i& cell, bool occupied) {
    world_.occupied[world_.index(cell.x(), cell.y())] = occupied ? 1 : 0;
    distance_ = floorplan::DistanceToOccupied(world_, 2);
  }

 private:
  void Step() {
    const Utime now{ms_ * 1000};
    if (ms_ % 10 == 0) {
      truth_ = {now, base_.position(), base_.yaw(), 0, 0};
      if (const auto seen = view(truth_)) driver().Push(seen);
    }
    if (ms_ % 100 == 0) Look(now);
    if (ms_ % 20 == 0) {
      ContactFlags contact = extra_contact(seconds());
      contact.bumper = contact.bumper || base_.bumper();
      bumped_ = bumped_ || base_.bumper();
      driver().Sense(contact);
      guard_.Sense(contact, now);
    }
    if (ms_ % (1000 / Driver::kRateHz) == 0) {
      const Driver::Output out = driver().Update(now);
      command_ = out.speed;
      for (const Event& event : out.events) {
        events.push_back(event);
        truth_at_events.push_back(truth_);
      }
      const kobuki::Twist allowed = guard_.Filter({command_.v, command_.w}, now);
      base_.Command(seconds(), allowed.v_m_s, allowed.w_rad_s);
    }
    const Eigen::Vector2d before = base_.position();
    base_.Step(seconds(), 1e-3, {});
    way_m_ += (base_.position() - before).norm();
    ++ms_;
  }

  floorplan::FloorMap world_;
  std::vector<float> distance_;
  sim::Base base_;
  kobuki::SafetyGuard guard_;
  RobotPose truth_;
  floorplan::Speed command_;
  bool bumped_ = false;
  double way_m_ = 0;
  int64_t ms_ = 0;
};

}  // namespace gw::navigate

// A navigator that drives a simulated base on true poses, for the tests of this folder.
#pragma once

#include <functional>
#include <vector>

#include "drivers/kobuki/core/safety_guard.h"
#include "tools/robot/navigate/navigator.h"
#include "tools/sim/sim/base.h"

namespace gw::navigate {

class TestDrive {
 public:
  // world: what is really there; the navigator knows its own map.
  TestDrive(Navigator navigator, floorplan::FloorMap world, const floorplan::Waypoint& start)
      : navigator_(std::move(navigator)),
        world_(std::move(world)),
        distance_(floorplan::DistanceToOccupied(world_, 2)),
        base_({}, world_, distance_, 1) {
    base_.Place(start.position, start.yaw);
  }

  // What the navigator is told of the truth; empty: nothing new.
  std::function<std::optional<RobotPose>(const RobotPose& truth)> view =
      [](const RobotPose& truth) { return truth; };
  std::function<ContactFlags(double t)> extra_contact = [](double) { return ContactFlags{}; };

  // Until it is finished or t seconds have passed since the begin.
  void RunUntil(double t) {
    while (seconds() < t && !navigator_.finished()) Step();
  }

  double seconds() const { return static_cast<double>(ms_) * 1e-3; }
  const sim::Base& base() const { return base_; }
  const Navigator& navigator() const { return navigator_; }
  bool bumped() const { return bumped_; }
  const floorplan::Speed& command() const { return command_; }
  int Count(EventKind kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [kind](const Event& e) { return e.kind == kind; }));
  }

  std::vector<Event> events;
  std::vector<RobotPose> truth_at_events;

 private:
  void Step() {
    const Utime now{ms_ * 1000};
    if (ms_ % 10 == 0) {
      truth_ = {now, base_.position(), base_.yaw(), 0, 0};
      if (const auto seen = view(truth_)) navigator_.Push(seen);
    }
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
  bool bumped_ = false;
  int64_t ms_ = 0;
};

}  // namespace gw::navigate

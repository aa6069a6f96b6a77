// Whatever drives a robot on poses: a tour of stops (navigator.h), or exploration (explorer.h). The
// process and the closed loop feed either of them alike.
//
// Pure: time comes with the samples; same calls, same commands.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/contract/grid.h"
#include "common/contract/samples.h"
#include "tools/robot/floorplan/pursuit.h"
#include "tools/robot/navigate/pose_guard.h"
#include "tools/robot/navigate/robot_pose.h"

namespace gw::navigate {

enum class EventKind {
  kLeg,          // a way to the stop was planned
  kReached,      // the stop
  kUnreachable,  // the stop
  kHeld,         // stands still: the pose is not good
  kResumed,
  kBumped,
  kBlocked,   // stands still: something is in the way, and no other way is left
  kFinished,  // all stops are reached or unreachable
};
const char* EventName(EventKind kind);

struct Event {
  EventKind kind = EventKind::kLeg;
  int stop = 0;  // of the tour, from 0; their number for kFinished
  RobotPose pose;
  std::string reason;  // of kUnreachable, kHeld, kBumped; empty otherwise
};

class Driver {
 public:
  Driver() = default;
  virtual ~Driver() = default;
  Driver(const Driver&) = default;
  Driver& operator=(const Driver&) = default;
  Driver(Driver&&) = default;
  Driver& operator=(Driver&&) = default;

  static constexpr int kRateHz = 20;

  // The newest pose; empty when dead reckoning goes on but has no place in the map.
  virtual void Push(const std::optional<RobotPose>& pose) = 0;
  // False: not used, the pose at its image is not known.
  virtual bool See(const ObstacleView& view) = 0;
  virtual void Sense(const ContactFlags& contact) = 0;
  // A piece of the floor map, received at `now`.
  virtual void Take(const GridUpdate& update, Utime now) = 0;

  struct Output {
    floorplan::Speed speed;
    std::vector<Event> events;
  };
  // At kRateHz. Times must not decrease.
  virtual Output Update(Utime now) = 0;

  virtual bool finished() const = 0;
  // All that was to be done was done. Precondition: finished.
  virtual bool succeeded() const = 0;
  // What was done, in one line.
  virtual std::string Summary() const = 0;
  // "stop 2 of 13, waypoint 7"
  virtual std::string NameOf(int stop) const = 0;
  // As given, not as it is driven to. Precondition: stop < num_stops().
  virtual const floorplan::Waypoint& place(int stop) const = 0;
  // Of a stop, as the tour's files number them; -1: it is none of these.
  virtual int waypoint(int stop) const = 0;
  virtual int num_stops() const = 0;
  virtual const floorplan::Leg& leg() const = 0;  // of the last kLeg
  virtual PoseState pose_state() const = 0;
  // Why it does not drive although its pose is good, for people; empty when it drives.
  virtual std::string waits_for() const = 0;
};

}  // namespace gw::navigate

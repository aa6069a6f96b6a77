// Drives a robot to the stops of a tour, one after the other, on the poses it is given.
//
// For every stop: plan a way around the obstacles of the map, follow it, turn to the stop's
// heading, stand still; then the stop is reached if the pose is within its tolerance, else it tries
// again. Without a good pose it stands (pose_guard.h) and plans anew when the pose is back. When
// the bumper or a cliff sensor says stop, it backs off, which also tells the base that the contact
// was noticed, and takes what it touched for an obstacle. A stop to which no way is left, that
// comes no nearer, or that is missed or blocked kAttempts times is unreachable: it goes on to the
// next.
//
// Pure: time comes with the samples; same calls, same commands.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/navigate_config.h"
#include "common/contract/samples.h"
#include "common/core/result.h"
#include "tools/robot/floorplan/floor_map.h"
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
  kFinished,  // all stops are reached or unreachable
};
const char* EventName(EventKind kind);

struct Event {
  EventKind kind = EventKind::kLeg;
  int stop = 0;  // of the tour, from 0; their number for kFinished
  RobotPose pose;
  std::string reason;  // of kUnreachable, kHeld, kBumped; empty otherwise
};

class Navigator {
 public:
  // tour: indices of waypoints. Those that cannot be visited (outside the map, in or too near to a
  // wall or to unknown cells, without a way to it) are named by complaints() and passed over when
  // their turn comes. Error kBadData names all of them when none can be visited.
  static Result<Navigator> Create(const NavigateConfig& config, floorplan::FloorMap map,
                                  const std::vector<floorplan::Waypoint>& waypoints,
                                  const std::vector<int>& tour);

  const std::vector<std::string>& complaints() const { return complaints_; }

  // The newest pose; empty when the one before is no longer true.
  void Push(const std::optional<RobotPose>& pose) { pose_ = pose; }
  void Sense(const ContactFlags& contact) { contact_ = contact; }

  struct Output {
    floorplan::Speed speed;
    std::vector<Event> events;
  };
  // At kRateHz. Times must not decrease.
  Output Update(Utime now);

  bool finished() const { return stop_ >= num_stops(); }
  int stop() const { return stop_; }  // where it is going
  int num_stops() const { return static_cast<int>(stops_.size()); }
  int num_unreachable() const { return num_unreachable_; }
  // As given, not as it is driven to. Precondition: stop < num_stops().
  const floorplan::Waypoint& place(int stop) const { return stops_[stop].given; }
  const floorplan::Leg& leg() const { return leg_; }  // of the last kLeg
  PoseState pose_state() const { return verdict_.state; }

  static constexpr int kRateHz = 20;
  static constexpr int kAttempts = 5;

 private:
  enum class Phase { kPlan, kFollow, kAlign, kSettle, kBackOff };

  struct Stop {
    floorplan::Waypoint given;
    floorplan::Waypoint aim;  // moved from walls, so that the robot can stand there
    double clearance_m = 0;   // to walls, of the ways to it and from it
  };

  Navigator(const NavigateConfig& config, floorplan::FloorMap map)
      : config_(config), map_(std::move(map)), guard_(config) {}

  Stop MakeStop(const floorplan::Waypoint& given) const;

  std::string WhyNotDriving() const;
  void Plan(Output* out);
  void Follow(Output* out);
  void Align(Utime now, Output* out);
  void Settle(Utime now, Output* out);
  void BeginBackOff(Utime now, Output* out);
  void BackOff(Utime now, Output* out);
  void WatchProgress(Utime now, Output* out);
  void GoOn(EventKind kind, const std::string& reason, Output* out);
  void Tell(EventKind kind, const std::string& reason, Output* out) const;
  void MarkObstacleAhead();
  NavigateConfig config_;
  floorplan::FloorMap map_;  // with what was bumped into
  std::vector<Stop> stops_;
  std::vector<std::string> complaints_;

  PoseGuard guard_;
  PoseGuard::Verdict verdict_;
  std::optional<RobotPose> pose_;
  ContactFlags contact_;

  Phase phase_ = Phase::kPlan;
  int stop_ = 0;
  int attempts_ = 0;
  int num_unreachable_ = 0;
  bool held_ = false;
  Utime last_bad_;
  bool told_finished_ = false;
  floorplan::Leg leg_;
  std::optional<floorplan::Pursuit> pursuit_;
  Utime phase_began_;
  Eigen::Vector2d bumped_at_ = Eigen::Vector2d::Zero();
  double nearest_m_ = 0;  // the stop has been, along the way
  std::optional<Utime> progressed_;
};

}  // namespace gw::navigate

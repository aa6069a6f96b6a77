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
// With a view of the obstacles (OBSTACLES of gw-grid) it drives no faster than it could stop within
// the floor that it sees, and plans around what the map does not have as soon as that stands in the
// way (obstacle_layer.h). When no way is left it stands for a while, since people walk on; then it
// backs off, looks around once, and tries again.
//
// Pure: time comes with the samples; same calls, same commands.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/config/navigate_config.h"
#include "common/contract/grid.h"
#include "common/contract/samples.h"
#include "common/core/result.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/pursuit.h"
#include "tools/robot/navigate/obstacle_layer.h"
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

class Navigator {
 public:
  // tour: indices of waypoints. Those that cannot be visited (outside the map, in or too near to a
  // wall or to unknown cells, without a way to it) are named by complaints() and passed over when
  // their turn comes. Error kBadData names all of them when none can be visited.
  static Result<Navigator> Create(const NavigateConfig& config, floorplan::FloorMap map,
                                  const std::vector<floorplan::Waypoint>& waypoints,
                                  const std::vector<int>& tour);

  const std::vector<std::string>& complaints() const { return complaints_; }

  // The newest pose; empty when dead reckoning goes on but has no place in the map: then the robot
  // looks around, twice at most, until it has one.
  void Push(const std::optional<RobotPose>& pose);
  // False: not used, the pose at its image is not known.
  bool See(const ObstacleView& view);
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
  enum class Phase { kPlan, kFollow, kAlign, kSettle, kBlocked, kBackOff, kLook };

  struct Stop {
    floorplan::Waypoint given;
    floorplan::Waypoint aim;  // moved from walls, so that the robot can stand there
    double clearance_m = 0;   // to walls, of the ways to it and from it
  };

  Navigator(const NavigateConfig& config, floorplan::FloorMap map)
      : config_(config),
        map_(std::move(map)),
        obstacles_(map_, config.clearance_m),
        guard_(config) {}

  Stop MakeStop(const floorplan::Waypoint& given) const;

  std::string WhyNotDriving() const;
  floorplan::Speed LookForPlace(Utime now);
  void Drive(Utime now, Output* out);
  void Plan(Utime now, Output* out);
  floorplan::Tour WayOn(const floorplan::FloorMap& map, double clearance) const;
  bool PlanAroundObstacles(Utime now, bool on_the_move, Output* out);
  void TakeLeg(floorplan::Leg leg, bool on_the_move, Output* out);
  void Follow(Utime now, Output* out);
  std::optional<double> FreeWay() const;
  void AvoidOnArc(floorplan::Speed* speed) const;
  double SpeedLimit(Utime now, std::optional<double> free_way) const;
  void BeginBlocked(Utime now, Output* out);
  void Blocked(Utime now, Output* out);
  bool RoomBehind() const;
  void Look(Output* out);
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
  ObstacleLayer obstacles_;  // that the map does not have
  std::vector<Stop> stops_;
  std::vector<std::string> complaints_;

  PoseGuard guard_;
  PoseGuard::Verdict verdict_;
  std::optional<RobotPose> pose_;
  std::deque<RobotPose> past_;  // the last second's poses, oldest first
  ContactFlags contact_;

  Phase phase_ = Phase::kPlan;
  int stop_ = 0;
  int attempts_ = 0;
  int num_unreachable_ = 0;
  bool held_ = false;
  bool unplaced_ = false;
  Utime held_since_;
  double looked_ = 0;  // rad, commanded while it had no place
  Utime last_bad_;
  bool told_finished_ = false;
  floorplan::Leg leg_;
  std::optional<floorplan::Pursuit> pursuit_;
  Utime phase_began_;
  Utime planned_;        // when it last tried to plan around obstacles
  int detours_ = 0;      // planned on the way to this stop
  double turned_ = 0;    // rad, while it looks around
  double last_yaw_ = 0;  // while it looks around
  Eigen::Vector2d bumped_at_ = Eigen::Vector2d::Zero();
  double nearest_m_ = 0;  // the stop has been, along the way
  std::optional<Utime> progressed_;
};

}  // namespace gw::navigate

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
#include "tools/robot/navigate/driver.h"
#include "tools/robot/navigate/obstacle_layer.h"
#include "tools/robot/navigate/pose_guard.h"
#include "tools/robot/navigate/robot_pose.h"

namespace gw::navigate {

class Navigator : public Driver {
 public:
  // tour: indices of waypoints. Those that cannot be visited (outside the map, in or too near to a
  // wall or to unknown cells, without a way to it) are named by complaints() and passed over when
  // their turn comes. Error kBadData names all of them when none can be visited.
  static Result<Navigator> Create(const NavigateConfig& config, floorplan::FloorMap map,
                                  const std::vector<floorplan::Waypoint>& waypoints,
                                  const std::vector<int>& tour);

  const std::vector<std::string>& complaints() const { return complaints_; }

  // Without stops: it stands until it is told where to go. `map` is what is known so far.
  Navigator(const NavigateConfig& config, floorplan::FloorMap map)
      : config_(config),
        map_(std::move(map)),
        obstacles_(map_, config.clearance_m),
        guard_(config) {}

  // A stop in place of the one it is going to, or one more when it has finished. clearance_m: of
  // the way there, to what is not free.
  void GoTo(const floorplan::Waypoint& place, double clearance_m);
  // The same: turn once around on the spot.
  void LookAround();
  // It stands, as if the stop it is going to were not there.
  void Drop();
  // The floor is known better than before. What was bumped into and what stands in the way now is
  // kept; a way that is not free any more is planned anew.
  void SetMap(floorplan::FloorMap map);

  // Empty: it has no place in the map, and looks around, twice at most, until it has one.
  void Push(const std::optional<RobotPose>& pose) override;
  bool See(const ObstacleView& view) override;
  void Sense(const ContactFlags& contact) override { contact_ = contact; }
  // A tour is driven on the map that it was planned on.
  void Take(const GridUpdate&, Utime) override {}
  Output Update(Utime now) override;

  bool finished() const override { return stop_ >= num_stops(); }
  bool succeeded() const override { return num_unreachable_ == 0; }
  std::string Summary() const override;
  std::string NameOf(int stop) const override;
  const floorplan::Waypoint& place(int stop) const override { return stops_[stop].given; }
  int waypoint(int stop) const override { return stops_[stop].waypoint; }
  int num_stops() const override { return static_cast<int>(stops_.size()); }
  const floorplan::Leg& leg() const override { return leg_; }
  PoseState pose_state() const override { return verdict_.state; }
  std::string waits_for() const override { return ""; }

  // As it was given, with what it bumped into.
  const floorplan::FloorMap& map() const { return map_; }
  int stop() const { return stop_; }  // where it is going
  int num_unreachable() const { return num_unreachable_; }
  bool held() const { return held_; }  // it stands, its pose is not good
  double left_m() const { return pursuit_ ? pursuit_->Left() : 0; }  // of the way it follows

  static constexpr int kAttempts = 5;

 private:
  enum class Phase { kPlan, kFollow, kAlign, kSettle, kBlocked, kBackOff, kLook };

  struct Stop {
    floorplan::Waypoint given;
    floorplan::Waypoint aim;   // moved from walls, so that the robot can stand there
    double clearance_m = 0;    // to walls, of the ways to it and from it
    int waypoint = -1;         // of the tour
    bool look_around = false;  // where it is, in place of going anywhere
  };

  Stop MakeStop(const floorplan::Waypoint& given) const;

  std::string WhyNotDriving() const;
  floorplan::Speed LookForPlace(Utime now);
  void Drive(Utime now, Output* out);
  void Plan(Utime now, Output* out);
  floorplan::Tour WayOn(const floorplan::FloorMap& map, double clearance) const;
  bool PlanAroundObstacles(Utime now, bool on_the_move, Output* out);
  void TakeLeg(floorplan::Leg leg, bool on_the_move, Output* out);
  void Follow(Utime now, Output* out);
  double ArrivalRadius() const;
  std::optional<double> FreeWay() const;
  bool HasRoomForArc() const;
  void AvoidOnArc(floorplan::Speed* speed) const;
  double SpeedLimit(Utime now, std::optional<double> free_way) const;
  void BeginBlocked(Utime now, Output* out);
  void Blocked(Utime now, Output* out);
  bool RoomBehind() const;
  void BeginLook();
  void Look(Output* out);
  void Align(Utime now, Output* out);
  void Settle(Utime now, Output* out);
  void BeginBackOff(Utime now, Output* out);
  void BackOff(Utime now, Output* out);
  void WatchProgress(Utime now, Output* out);
  void GoOn(EventKind kind, const std::string& reason, Output* out);
  void Tell(EventKind kind, const std::string& reason, Output* out) const;
  void SetStop(const Stop& stop);
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
  int replans_ = 0;      // for other maps, since it last came nearer
  bool moving_ = false;  // the leg that is planned takes the place of one that it drives
  double turned_ = 0;    // rad, while it looks around
  double last_yaw_ = 0;  // while it looks around
  std::vector<Eigen::Vector2d> bumped_into_;  // centres of what it touched
  Eigen::Vector2d bumped_at_ = Eigen::Vector2d::Zero();
  double nearest_m_ = 0;  // the stop has been, along the way
  std::optional<Utime> progressed_;
};

}  // namespace gw::navigate

// Drives a differential base along one leg: pure pursuit (Coulter, CMU-RI-TR-92-01), with turns on
// the spot where the way leaves sideways.
#pragma once

#include <Eigen/Core>

#include "tools/robot/floorplan/planner.h"

namespace gw::floorplan {

struct Speed {
  double v = 0;  // m/s, forward
  double w = 0;  // rad/s, counter-clockwise
};

struct PursuitConfig {
  double max_v = 0.5;   // m/s
  double max_w = 1.05;  // rad/s
  double look_ahead_m = 0.45;
};

// Shortest turn from one heading to another, in [-pi, pi].
double AngleTo(double from, double to);

// Turns on the spot by `error` rad: proportional, limited. The gain is stable with the 0.25 s
// between a command and the motion of a Kobuki.
Speed TurnBy(double error, double max_w);

class Pursuit {
 public:
  // Precondition: the leg has a point. on_the_move: the leg takes the place of one that is being
  // driven, so that the robot need not turn on the spot first.
  Pursuit(Leg leg, const PursuitConfig& config, bool on_the_move = false)
      : leg_(std::move(leg)), config_(config), turning_(!on_the_move) {}

  // For the pose now; call at a fixed rate. Slows down before the end and does not stop there: the
  // caller decides when it has arrived. share: of max_v, in (0, 1]; the slower it drives, the
  // nearer it looks ahead, so that it cuts corners less.
  Speed Update(const Eigen::Vector2d& position, double yaw, double share = 1);

  // m, to where it is on the leg: far when something carried the robot away.
  double DistanceToLeg(const Eigen::Vector2d& position) const {
    return (leg_[nearest_] - position).norm();
  }
  size_t nearest() const { return nearest_; }  // the leg's point where it is
  // m, along the leg.
  double Left() const { return kLegSpacing * static_cast<double>(leg_.size() - 1 - nearest_); }
  double DistanceToEnd(const Eigen::Vector2d& position) const {
    return (leg_.back() - position).norm();
  }

 private:
  Leg leg_;
  PursuitConfig config_;
  size_t nearest_ = 0;  // point of the leg
  bool turning_;        // on the spot
};

}  // namespace gw::floorplan

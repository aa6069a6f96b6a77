// A differential-drive base of the size and manners of a Kobuki: speed limits, dead time and lag
// between command and motion, wheels that are not quite what the odometry believes, slip, contact.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"
#include "tools/sim/sim/smooth_noise.h"

namespace gw::sim {

struct BaseConfig {
  double max_v = 0.7;            // m/s
  double max_w = 1.92;           // rad/s: 110 deg/s
  double dead_time_s = 0.17;     // from command to first reaction
  double lag_s = 0.08;           // first order
  double max_wheel_accel = 1.2;  // m/s^2
  double radius_m = 0.1775;
  double height_m = 0.42;  // of a TurtleBot2
  double track_m = 0.23;
  // What the odometry does not know. The first three are sizes: sign and exact value follow from
  // the seed, between 0.6 and 1.4 times the size.
  double scale_error = 0.01;            // wheel radius, both wheels
  double wheel_difference = 0.0002;     // right minus left, relative
  double track_error = 0.008;           // effective track, relative
  double slip_per_sqrt_m = 0.004;       // random, along the way
  double heading_deg_per_sqrt_m = 0.2;  // random
  double carpet_factor = 2.5;           // random slip on carpet, times normal
  // Tyres run at a slip angle in proportion to the sideways force (linear tyre; a rubber tyre gives
  // way by some tenths of a degree at the 0.25 m/s^2 of such a robot in a curve).
  double side_slip = 0.01;             // rad per m/s^2
  double sideways_per_sqrt_m = 0.002;  // random
  // A skid-steer base: its wheels cannot roll along a curve. It turns less than its geometry says,
  // about a point that lies before or behind the middle (a size, as above), and never twice alike.
  double track_factor = 1;  // effective track over the geometric one
  double turn_centre_m = 0;
  double turn_deg_per_sqrt_rad = 0;  // random, per angle turned
};

// What the world does to the base in one step.
struct Disturbance {
  double traction = 1;  // motion over ground per motion of the wheels
  bool on_carpet = false;
  Eigen::Vector2d push_v = Eigen::Vector2d::Zero();  // m/s in the body, beside the wheels' motion
  double push_w = 0;                                 // rad/s
};

class Base {
 public:
  // distance: DistanceToOccupied of `obstacles`. Both must outlive the base.
  Base(const BaseConfig& config, const floorplan::FloorMap& obstacles,
       const std::vector<float>& distance, uint64_t seed);

  void Place(const Eigen::Vector2d& p, double yaw) {
    position_ = p;
    yaw_ = yaw;
  }
  // Takes effect after the dead time.
  void Command(double time_s, double v, double w);
  // Moves on from time_s to time_s + dt.
  void Step(double time_s, double dt, const Disturbance& disturbance);

  const Eigen::Vector2d& position() const { return position_; }
  double yaw() const { return yaw_; }
  double v() const { return 0.5 * (left_v_ + right_v_); }  // of the wheels
  double w() const { return (right_v_ - left_v_) / (config_.track_m * config_.track_factor); }
  double left_way() const { return left_way_; }  // m that the wheel's rim has turned
  double right_way() const { return right_way_; }
  bool bumper() const { return bumper_; }
  const BaseConfig& config() const { return config_; }

 private:
  struct Timed {
    double time_s, v, w;
  };
  BaseConfig config_;
  const floorplan::FloorMap& obstacles_;
  const std::vector<float>& distance_;
  struct Motion {  // of the body over the ground
    double v = 0, sideways = 0, w = 0;
  };
  // What becomes of the wheels' rims' motion over dt.
  Motion Roll(double dt, const Disturbance& disturbance);

  double left_scale_, right_scale_, track_, turn_centre_;
  SmoothNoise slip_noise_, heading_noise_, sideways_noise_, turn_noise_;
  std::deque<Timed> commands_;
  double wanted_v_ = 0, wanted_w_ = 0;
  double left_v_ = 0, right_v_ = 0;  // m/s of the rims
  double left_way_ = 0, right_way_ = 0;
  double way_ = 0;   // m, of the tyres
  double turn_ = 0;  // rad, in either direction
  Eigen::Vector2d position_ = Eigen::Vector2d::Zero();
  double yaw_ = 0;
  bool bumper_ = false;
};

}  // namespace gw::sim

// The real motion of a recorded robot, to render its camera along it: the way from a ground-truth
// file, and the odometry that its real wheels reported.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/se3.h"
#include "tools/robot/floorplan/floor_map.h"

namespace gw::sim {

class RecordedMotion {
 public:
  // Files of lines `t x y z qx qy qz qw` (s, m; # starts a comment): the body in the world, and the
  // odometry's own pose. Only x, y and heading are used. Seconds here count from the first pose
  // that the odometry covers, to the last. The first file may be sparse (kept scans of a laser):
  // the odometry carries from pose to pose; poses out of order are left out of it. Errors:
  // kNotFound; kBadData with file and line for a bad line or odometry whose times do not grow, for
  // 5 s without odometry, for 5 m by odometry without a pose, or files that share less than a
  // second.
  static Result<RecordedMotion> Load(const std::string& trajectory, const std::string& odometry);

  struct Planar {
    Eigen::Vector2d position;
    double yaw = 0;
  };
  // A curve with continuous acceleration; it is the truth of the simulation. Within a quarter of a
  // metre it has the shape of the odometry, over more it follows the mean of the recorded poses:
  // from pose to pose these are off by centimetres and degrees, and some jump by half a metre,
  // which no robot does. Where the odometry stands, the robot stands. It is the way of the
  // odometry's own frame, the body, which is found by least squares: references follow a place that
  // is up to 17 cm and 2.3 degrees beside it (docs/results.md). Clamped to [0, duration_s].
  Planar At(double t) const;
  double duration_s() const { return duration_s_; }

  struct Odometry {
    double t = 0;  // s
    SE3 T_OB;
  };
  const std::vector<Odometry>& odometry() const { return odometry_; }
  double odometry_rate_hz() const;

  // Do the recorded poses come often enough to tell what an IMU would have measured? Kept scans of
  // a laser, a second and more apart, do not: each turns the robot by degrees against its wheels.
  bool TellsRates() const { return reference_interval_s_ < 0.5; }

  // A floor with walls `half_width` metres on both sides of the way.
  floorplan::FloorMap CorridorAround(double half_width) const;

 private:
  double duration_s_ = 0;
  double reference_interval_s_ = 0;     // mean
  std::vector<Eigen::Vector3d> knots_;  // x, y, unwrapped yaw, every kKnotSpacing
  std::vector<Odometry> odometry_;
};

}  // namespace gw::sim

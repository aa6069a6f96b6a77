// The robot on the floor map, from POSE or from GROUND_TRUTH.
#pragma once

#include <Eigen/Core>

#include "common/contract/dead_reckoning.h"
#include "common/contract/samples.h"
#include "common/core/time.h"
#include "tools/robot/floorplan/waypoints.h"

namespace gw::navigate {

// In the frame M of the floor map.
struct RobotPose {
  Utime utime;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // m
  double yaw = 0;                                      // rad, in [-pi, pi]
  double sigma_m = 0;    // position, in its least certain direction on the floor (1 sigma)
  double sigma_rad = 0;  // heading (1 sigma)
};

// T_MW for a world W (origin and heading at the first body pose, z up) that began where the robot
// stood at `start` on the map.
SE3 MapFromWorld(const floorplan::Waypoint& start);

RobotPose OnMap(const SE3& T_MW, const Pose& pose);
// The frame of the simulator's ground truth is that of its map.
RobotPose OnMap(const GroundTruth& truth);

}  // namespace gw::navigate

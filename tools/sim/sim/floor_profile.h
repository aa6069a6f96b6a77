// How uneven the floor is: waves of less than a millimetre, and now and then a joint or a cable of
// a few millimetres. Lifts and tilts the robot a little.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/core/se3.h"

namespace gw::sim {

class FloorProfile {
 public:
  // roughness: 1 is a normal office floor, 0 is ideal.
  FloorProfile(uint64_t seed, double roughness) : seed_(seed), roughness_(roughness) {}

  double Height(const Eigen::Vector2d& p) const;  // m
  // Pose of a body that stands at p with this heading: on its two wheels and its casters.
  SE3 BodyPose(const Eigen::Vector2d& p, double yaw) const;

 private:
  uint64_t seed_;
  double roughness_;
};

}  // namespace gw::sim

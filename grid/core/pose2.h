// Motion on the floor: the part of a pose that a floor map knows.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "common/core/se3.h"

namespace gw::grid {

// Like SE3, T_AB maps coordinates of B into A; m, rad.
class Pose2 {
 public:
  Pose2() = default;
  Pose2(const Eigen::Vector2d& p, double yaw)
      : p_(p), yaw_(yaw), cos_(std::cos(yaw)), sin_(std::sin(yaw)) {}
  // The pose of a body that stands on the floor: tilt and height are left out.
  explicit Pose2(const SE3& T)
      : Pose2(T.translation().head<2>(), HeadingOf(T.rotation() * Eigen::Vector3d::UnitX())) {}

  const Eigen::Vector2d& translation() const { return p_; }
  double yaw() const { return yaw_; }

  Eigen::Vector2d Rotate(const Eigen::Vector2d& v) const {
    return {cos_ * v.x() - sin_ * v.y(), sin_ * v.x() + cos_ * v.y()};
  }
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const { return Rotate(point) + p_; }
  Pose2 operator*(const Pose2& other) const { return {*this * other.p_, yaw_ + other.yaw_}; }
  Pose2 inverse() const {
    const Pose2 back({0, 0}, -yaw_);
    return {-back.Rotate(p_), -yaw_};
  }

 private:
  static double HeadingOf(const Eigen::Vector3d& forward) {
    return std::atan2(forward.y(), forward.x());
  }

  Eigen::Vector2d p_ = Eigen::Vector2d::Zero();
  double yaw_ = 0, cos_ = 1, sin_ = 0;
};

}  // namespace gw::grid

// A pose without its tilt, where what told "up" is not believed.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "common/core/se3.h"

namespace gw::dr_ekf {

// Place and heading (of body x) of T_OB; roll and pitch are zero.
inline SE3 Levelled(const SE3& T_OB) {
  const Eigen::Vector3d ahead = T_OB.rotation() * Eigen::Vector3d::UnitX();
  const Eigen::AngleAxisd heading(std::atan2(ahead.y(), ahead.x()), Eigen::Vector3d::UnitZ());
  return {Eigen::Quaterniond(heading), T_OB.translation()};
}

}  // namespace gw::dr_ekf

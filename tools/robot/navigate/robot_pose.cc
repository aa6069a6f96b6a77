#include "tools/robot/navigate/robot_pose.h"

#include <algorithm>
#include <cmath>

namespace gw::navigate {
namespace {

RobotPose Planar(Utime utime, const SE3& T_MB) {
  RobotPose out;
  out.utime = utime;
  out.position = T_MB.translation().head<2>();
  const Eigen::Vector3d ahead = T_MB.rotation() * Eigen::Vector3d::UnitX();
  out.yaw = std::atan2(ahead.y(), ahead.x());
  return out;
}

}  // namespace

SE3 MapFromWorld(const floorplan::Waypoint& start) {
  return SE3(ExpSO3({0, 0, start.yaw}), {start.position.x(), start.position.y(), 0});
}

RobotPose OnMap(const SE3& T_MW, const Pose& pose) {
  RobotPose out = Planar(pose.utime, T_MW * pose.T_WB);
  // The perturbation is in B, whose x and y lie on the floor.
  const Eigen::Matrix2d cov = pose.cov_T_WB.topLeftCorner<2, 2>();
  const double mean = 0.5 * cov.trace();
  const double spread = std::hypot(0.5 * (cov(0, 0) - cov(1, 1)), cov(0, 1));
  out.sigma_m = std::sqrt(std::max(0.0, mean + spread));
  out.sigma_rad = std::sqrt(std::max(0.0, pose.cov_T_WB(5, 5)));
  return out;
}

RobotPose OnMap(const GroundTruth& truth) {
  return Planar(truth.utime, truth.T_GB);
}

}  // namespace gw::navigate

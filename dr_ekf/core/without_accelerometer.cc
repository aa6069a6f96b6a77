#include "dr_ekf/core/without_accelerometer.h"

#include <cmath>

#include "dr_ekf/core/levelled.h"

namespace gw::dr_ekf {

TwinFrame FrameOfTwin(const SE3& T_OB, const SE3& T_OB_twin, double most_tilt) {
  const Eigen::Vector3d up_B = T_OB.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  TwinFrame frame;
  frame.levelled = up_B.z() < std::cos(most_tilt);
  const SE3 kept = frame.levelled ? Levelled(T_OB) : T_OB;
  frame.T_O_twin = kept * T_OB_twin.inverse();
  frame.error = kept.Adjoint() * (T_OB_twin.inverse() * kept).Log();
  return frame;
}

FilterState GoOnAsTwin(const FilterState& twin, const TwinFrame& frame, const FilterState& before) {
  FilterState state = twin;
  state.reset_counter = before.reset_counter + frame.levelled;
  state.counters = before.counters;
  state.wheels_stand = before.wheels_stand;
  // Errors of the state are relative to its poses and stay what they are; that of the frame is one
  // that pose and clone have in common.
  state.T_OS = frame.T_O_twin * twin.T_OS;
  state.T_OS_clone = frame.T_O_twin * twin.T_OS_clone;
  const Vector6d pose = state.T_OS.inverse().Adjoint() * frame.error;
  const Vector6d clone = state.T_OS_clone.inverse().Adjoint() * frame.error;
  state.P.block<6, 6>(kPose, kPose) += pose * pose.transpose();
  state.P.block<6, 6>(kClone, kClone) += clone * clone.transpose();
  state.P.block<6, 6>(kPose, kClone) += pose * clone.transpose();
  state.P.block<6, 6>(kClone, kPose) += clone * pose.transpose();
  return state;
}

}  // namespace gw::dr_ekf

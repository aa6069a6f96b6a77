// DrModel: a wheeled robot is on a floor. With an accelerometer "up" is known to a fraction of a
// degree, and the way that B's x points at is off from the floor by how the accelerometer is
// mounted: over 100 m that is metres of height. A floor has hardly any (docs/adr/0018).
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {

void DrModel::UpdateHeight(double way, FilterState& state) const {
  if (!state.aligned || way <= 0) return;  // without "up" it is taken to stand flat
  if (OnRamp(state)) return;
  const double height = (state.T_OS * T_SB_.translation()).z();
  const Eigen::RowVector3d up = state.T_OS.rotation().toRotationMatrix().row(2);  // of O, in S
  Eigen::Matrix<double, 1, kErrorSize> H = Eigen::Matrix<double, 1, kErrorSize>::Zero();
  H.segment<3>(kPose) = up;
  H.segment<3>(kPose + 3) = -up * Skew(T_SB_.translation());
  // Behind a ramp it is the floor from before where the height, as well as it is known, says so.
  const double known = (H * state.P * H.transpose())(0);
  if (std::abs(height - state.floor) >
      config_.gate_sigma * std::sqrt(Square(kFloorHeight) + known)) {
    state.floor = height;
    return;
  }
  // A floor that is Gaussian with this correlation length tells one height per length.
  const double variance = Square(kFloorHeight) * kFloorTiltWay / way;
  using Scalar = Eigen::Matrix<double, 1, 1>;
  Update<1>(H, Scalar(state.floor - height), Scalar(variance), PoseUpdate::kDefineWay, state);
}

// Whether the robot drives up or down by more than floors, and what is not known of its tilt and of
// its IMU's mounting, make of it.
bool DrModel::OnRamp(const FilterState& state) const {
  const Eigen::RowVector3d up = state.T_OS.rotation().toRotationMatrix().row(2);
  const double rise = up.x() + state.climb * up.z();  // per way driven
  Eigen::Matrix<double, 1, kErrorSize> H = Eigen::Matrix<double, 1, kErrorSize>::Zero();
  H.segment<3>(kPose + 3) = -up * Skew(Eigen::Vector3d(1, 0, state.climb));
  H[kClimb] = up.z();
  const double known = (H * state.P * H.transpose())(0);
  return std::abs(rise) > config_.gate_sigma * std::sqrt(Square(kFloorTilt) + known);
}

}  // namespace gw::dr_ekf

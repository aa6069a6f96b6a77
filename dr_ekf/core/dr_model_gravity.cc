// DrModel: which way is up, from the accelerometer, when it is first heard.
#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

void DrModel::Align(const ImuSample& imu, FilterState& state) const {
  const Vector3d up_S = (R_BI_ * imu.a_I_m_s2).normalized();
  if (!up_S.allFinite()) return;
  // Smallest rotation that makes the measured force vertical; the heading stays.
  const SE3 T_OB = state.T_OS * T_SB_;
  const Vector3d up_O = T_OB.rotation() * up_S;
  const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(up_O, Vector3d::UnitZ());
  const SE3 aligned_T_OB(tilt * T_OB.rotation(), T_OB.translation());
  state.T_OS = aligned_T_OB * T_BS_;
  state.aligned = true;
  state.leveling = true;
  state.leveling_end = imu.utime + Milliseconds(config_.stationary_ms);
  // Around B: the place of B is known, its tilt is not.
  Matrix6d pose_B = adj_BS_ * state.P.block<6, 6>(kPose, kPose) * adj_BS_.transpose();
  for (int i : {3, 4}) {
    pose_B.row(i).setZero();
    pose_B.col(i).setZero();
    pose_B(i, i) = Square(kTiltPrior);
  }
  const Matrix6d adj_SB = T_SB_.Adjoint();
  state.P.topRows<6>().setZero();
  state.P.leftCols<6>().setZero();
  state.P.block<6, 6>(kPose, kPose) = adj_SB * pose_B * adj_SB.transpose();
  state.transition.topRows<6>().setZero();
  ClonePose(state.clone_utime, state);
  state.has_clone = false;
  if (state.has_wheel) ++state.reset_counter;  // the wheels had begun without gravity
}

void DrModel::Level(FilterState& state) const {
  const Vector3d up_S = state.T_OS.rotation().conjugate() * kUp;
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 3>(0, 3) = Skew(up_S);
  H.block<3, 3>(0, kAccelBias) = R_BI_;
  const Vector3d innovation = state.accel_B - R_BI_ * state.accel_bias - up_S;
  const Matrix3d R =
      Matrix3d::Identity() * (Square(imu_.accel_noise) * imu_.rate_hz + Square(kLevelingSigma));
  Update<3>(H, innovation, R, PoseUpdate::kCorrect, state);
}

}  // namespace gw::dr_ekf

#include "dr_ekf/core/error_state.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gw::dr_ekf {

template <int kRows>
void Update(const Eigen::Matrix<double, kRows, kErrorSize>& H,
            const Eigen::Matrix<double, kRows, 1>& innovation,
            const Eigen::Matrix<double, kRows, kRows>& R, PoseUpdate mode, FilterState& state) {
  const bool hold = mode == PoseUpdate::kHold;
  const Eigen::Matrix<double, kErrorSize, kRows> PHt = state.P * H.transpose();
  const Eigen::Matrix<double, kRows, kRows> S = H * PHt + R;
  Eigen::Matrix<double, kErrorSize, kRows> K = S.ldlt().solve(PHt.transpose()).transpose();
  if (hold) {
    K.template topRows<9>().setZero();
    K.template bottomRows<6>().setZero();
  }
  ErrorMatrix IKH = ErrorMatrix::Identity();
  IKH.noalias() -= K * H;
  const ErrorMatrix P = IKH * state.P * IKH.transpose() + K * R * K.transpose();
  state.P = 0.5 * (P + P.transpose());
  state.transition = (IKH * state.transition).eval();

  if (mode == PoseUpdate::kCorrect) {
    const auto K_pose = K.template topRows<6>();
    state.correction_rate += K_pose * S * K_pose.transpose() / kCorrectionMemory;
  }

  const ErrorVector d = K * innovation;
  if (!hold) {
    state.T_OS = state.T_OS * SE3::Exp(d.segment<6>(kPose));
    state.T_OS_clone = state.T_OS_clone * SE3::Exp(d.segment<6>(kClone));
    state.v_OS_S += d.segment<3>(kVelocity);
  }
  state.gyro_bias += d.segment<3>(kGyroBias);
  state.accel_bias += d.segment<3>(kAccelBias);
  // Far outside the prior the linear model means nothing; the bounds keep hostile data harmless.
  state.wheel_scale = std::clamp(state.wheel_scale + d[kWheelScale], 0.5, 2.0);
  state.yaw_scale = std::clamp(state.yaw_scale + d[kYawScale], 0.5, 2.0);
}

template void Update<1>(const Eigen::Matrix<double, 1, kErrorSize>&,
                        const Eigen::Matrix<double, 1, 1>&, const Eigen::Matrix<double, 1, 1>&,
                        PoseUpdate, FilterState&);
template void Update<3>(const Eigen::Matrix<double, 3, kErrorSize>&, const Eigen::Vector3d&,
                        const Eigen::Matrix3d&, PoseUpdate, FilterState&);

void ApplyTransition(const TopTransition& F, FilterState& state) {
  const Eigen::Matrix<double, 9, kErrorSize> top = F * state.P.topRows<kClone>();
  state.P.topRows<9>() = top;
  state.P.leftCols<9>() = top.transpose();
  state.P.topLeftCorner<9, 9>() = top.leftCols<kClone>() * F.transpose();
  const Eigen::Matrix<double, 9, kErrorSize> moved = F * state.transition.topRows<kClone>();
  state.transition.topRows<9>() = moved;
}

void ClonePose(Utime utime, FilterState& state) {
  state.T_OS_clone = state.T_OS;
  state.clone_utime = utime;
  state.has_clone = true;
  state.way_unmeasured = false;
  state.yaw_unmeasured = false;
  state.P.middleRows<6>(kClone) = state.P.middleRows<6>(kPose).eval();
  state.P.middleCols<6>(kClone) = state.P.middleCols<6>(kPose).eval();
  state.transition.middleRows<6>(kClone) = state.transition.middleRows<6>(kPose).eval();
}

}  // namespace gw::dr_ekf

#include "dr_ekf/core/error_state.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gw::dr_ekf {

namespace {

// What a measurement says of parameters (biases, scales) also tells where the whole way so far has
// led: an optimal gain would move the pose of minutes ago, and with it the pose now, in one step
// that looks like motion. Dead reckoning is there for relative motion. So that part of the
// correction of the clone which follows from that of the parameters is left out, for place and
// heading, and the pose moves with the clone. Tilt is absolute (gravity) and is corrected in full.
// Any gain is honest in the Joseph form.
template <int kRows>
void KeepThePast(const FilterState& state, Eigen::Matrix<double, kErrorSize, kRows>* K) {
  constexpr int kParameters = kClone - kGyroBias;
  const Eigen::Vector3d up = state.T_OS_clone.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix<double, kParameters, kParameters> cov =
      state.P.block<kParameters, kParameters>(kGyroBias, kGyroBias);
  // Parameters that are known have no variance; LDLT gives them no part.
  Eigen::Matrix<double, 6, kRows> shift =
      state.P.block<6, kParameters>(kClone, kGyroBias) *
      cov.ldlt().solve(K->template middleRows<kParameters>(kGyroBias));
  shift.template bottomRows<3>() = (up * up.transpose() * shift.template bottomRows<3>()).eval();
  K->template middleRows<6>(kClone) -= shift;
  const SE3 T_now_clone = state.T_OS.inverse() * state.T_OS_clone;
  K->template middleRows<6>(kPose) -= T_now_clone.Adjoint() * shift;
}

// Moves a pose by its correction, and its error along: an error of O, which all poses have in
// common and no measurement between two of them tells, must stay one for the moved pose. Else the
// next measurement takes a part of it for knowledge.
void MovePose(const Vector6d& d, int begin, SE3* T, FilterState& state) {
  *T = *T * SE3::Exp(d);
  const Matrix6d adj = SE3::Exp(-d).Adjoint();
  state.P.middleRows<6>(begin) = (adj * state.P.middleRows<6>(begin)).eval();
  state.P.middleCols<6>(begin) = (state.P.middleCols<6>(begin) * adj.transpose()).eval();
  state.transition.middleRows<6>(begin) = (adj * state.transition.middleRows<6>(begin)).eval();
}

}  // namespace

template <int kRows>
void Update(const Eigen::Matrix<double, kRows, kErrorSize>& H,
            const Eigen::Matrix<double, kRows, 1>& innovation,
            const Eigen::Matrix<double, kRows, kRows>& R, PoseUpdate mode, FilterState& state) {
  const bool hold = mode == PoseUpdate::kHold;
  const Eigen::Matrix<double, kErrorSize, kRows> PHt = state.P * H.transpose();
  const Eigen::Matrix<double, kRows, kRows> S = H * PHt + R;
  Eigen::Matrix<double, kErrorSize, kRows> K = S.ldlt().solve(PHt.transpose()).transpose();
  // Bad stamps tell nothing of the wheels' scale, nor does a way that is not rolled tell where the
  // wheels roll.
  if (state.scale_untold) K.row(kWheelScale).setZero();
  if (state.rolling_untold) {
    K.template middleRows<kClone - kCrab>(kCrab).setZero();
  }
  if (hold) {
    K.template topRows<9>().setZero();
    K.template bottomRows<kErrorSize - kClone>().setZero();
  } else if (mode == PoseUpdate::kTrackOnly) {
    const Eigen::Matrix<double, 1, kRows> track = K.row(kYawScale);
    K.setZero();
    K.row(kYawScale) = track;
  } else if (mode == PoseUpdate::kDefine) {
    K.template middleRows<kClone - kGyroBias>(kGyroBias).setZero();
  } else if (state.has_clone) {
    KeepThePast<kRows>(state, &K);
  }
  // Joseph's form (I - K H) P (I - K H)^T + K R K^T, honest for any gain, multiplied out: the rank
  // of the change is that of the measurement.
  const Eigen::Matrix<double, kErrorSize, kRows> half =
      PHt - 0.5 * K * S;  // P - half K^T - K half^T
  state.P.noalias() -= half * K.transpose();
  state.P.noalias() -= K * half.transpose();
  state.P = (0.5 * (state.P + state.P.transpose())).eval();
  const Eigen::Matrix<double, kRows, kErrorSize> moved = H * state.transition;
  state.transition.noalias() -= K * moved;

  if (mode == PoseUpdate::kCorrect || mode == PoseUpdate::kDefineWay) {
    Eigen::Matrix<double, 6, kRows> K_pose = K.template topRows<6>();
    if (mode == PoseUpdate::kDefineWay) K_pose.template topRows<3>().setZero();
    state.correction_rate += K_pose * S * K_pose.transpose() / kCorrectionMemory;
  }

  const ErrorVector d = K * innovation;
  if (!hold) {
    MovePose(d.segment<6>(kPose), kPose, &state.T_OS, state);
    MovePose(d.segment<6>(kClone), kClone, &state.T_OS_clone, state);
    state.v_OS_S += d.segment<3>(kVelocity);
    state.clone_sum += d.segment<2>(kCloneSum);
    state.new_sum += d.segment<2>(kNewSum);
  }
  state.gyro_bias += d.segment<3>(kGyroBias);
  state.accel_bias += d.segment<3>(kAccelBias);
  // Far outside the prior the linear model means nothing; the bounds keep hostile data harmless.
  state.gyro_scale = (state.gyro_scale + d.segment<3>(kGyroScale)).cwiseMax(0.8).cwiseMin(1.2);
  state.wheel_scale = std::clamp(state.wheel_scale + d[kWheelScale], 0.5, 2.0);
  state.yaw_scale = std::clamp(state.yaw_scale + d[kYawScale], kLeastYawScale, kMostYawScale);
  state.turn_per_way = std::clamp(state.turn_per_way + d[kTurnPerWay], -0.5, 0.5);
  state.climb = std::clamp(state.climb + d[kClimb], -0.2, 0.2);
  state.crab = std::clamp(state.crab + d[kCrab], -0.2, 0.2);
  state.turn_centre = std::clamp(state.turn_centre + d[kTurnCentre], -0.5, 0.5);
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

void BeginSum(const Eigen::Matrix2d& cov, FilterState& state) {
  state.new_sum.setZero();
  state.P.middleRows<2>(kNewSum).setZero();
  state.P.middleCols<2>(kNewSum).setZero();
  state.P.block<2, 2>(kNewSum, kNewSum) = cov;
  state.transition.middleRows<2>(kNewSum).setZero();
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
  state.clone_sum = state.new_sum;
  state.P.middleRows<2>(kCloneSum) = state.P.middleRows<2>(kNewSum).eval();
  state.P.middleCols<2>(kCloneSum) = state.P.middleCols<2>(kNewSum).eval();
  state.transition.middleRows<2>(kCloneSum) = state.transition.middleRows<2>(kNewSum).eval();
  BeginSum(Eigen::Matrix2d::Zero(), state);
}

}  // namespace gw::dr_ekf

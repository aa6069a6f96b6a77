// DrModel: whether the robot stands still, and what a still robot tells of its biases.
#include <algorithm>
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

void DrModel::UpdateImuStillness(const ImuSample& imu, FilterState& state) const {
  // Five sigma of the sample noise, and what a standing robot's motors and fans add.
  const double gyro_limit = 5 * imu_.gyro_noise * std::sqrt(imu_.rate_hz) + 0.005;
  const double accel_limit = 5 * imu_.accel_noise * std::sqrt(imu_.rate_hz) + 0.05;
  constexpr double kForget = 0.05;  // the reference follows drift, not motion
  const Vector3d gyro = R_BI_ * imu.w_I_rad_s;
  const Vector3d accel = R_BI_ * imu.a_I_m_s2;
  const bool first = state.imu_still_since.us == 0 && state.gyro_reference.isZero();
  const bool moved =
      (gyro - state.gyro_reference).norm() > gyro_limit ||
      (imu.has_accel && imu_.has_accel && (accel - state.accel_reference).norm() > accel_limit);
  if (first || moved) {
    state.imu_still_since = imu.utime;
    state.gyro_reference = gyro;
    state.accel_reference = accel;
  } else {
    state.gyro_reference += kForget * (gyro - state.gyro_reference);
    state.accel_reference += kForget * (accel - state.accel_reference);
  }
}

void DrModel::UpdateWheelStillness(const WheelSample& sample, FilterState& state) const {
  const double limit_m = sample.has_ticks ? 1.5 * tick_m_ : 1e-5;
  const double limit_rad = sample.has_ticks ? 1.5 * tick_m_ / wheel_.track_width_m : 1e-5;
  state.still_way += sample.dx_m;
  state.still_yaw += sample.dyaw_rad;
  bool still = std::abs(state.still_way) <= limit_m && std::abs(sample.dy_m) <= limit_m &&
               std::abs(state.still_yaw) <= limit_rad;
  if (sample.has_heading && state.has_heading &&
      std::abs(WrapAngle(sample.heading_rad - state.heading)) > 2.5 * kHeadingStep) {
    still = false;
  }
  if (still && !state.wheel_still) state.wheel_still_since = sample.utime_begin;
  if (!still) state.still_way = state.still_yaw = 0;
  state.wheel_still = still;
}

void DrModel::UpdateStationary(Utime utime, FilterState& state) const {
  const DurationUs wait = Milliseconds(config_.stationary_ms);
  bool now = WheelsAlive(state) && state.wheel_still && utime - state.wheel_still_since >= wait;
  if (now && ImuAlive(state)) {
    // A steady rate under still wheels is a bias only if the bias may be that large.
    const double bias_sigma = std::sqrt(state.P.diagonal().segment<3>(kGyroBias).maxCoeff());
    const double rate = (state.gyro_reference - R_BI_ * state.gyro_bias).norm();
    now = utime - state.imu_still_since >= wait && rate < config_.gate_sigma * bias_sigma + 0.01;
    // A rate that is steady for longer is a bias that jumped: hands and carpets turn unevenly.
    if (!now && rate < kMaxBiasJump &&
        utime - std::max(state.imu_still_since, state.wheel_still_since) >=
            DurationFromSeconds(kSteadyRateFor)) {
      now = true;
      ++state.counters.gyro_bias_jumps;
      state.P.diagonal().segment<3>(kGyroBias).array() += Square(rate);
    }
  }
  if (now == state.stationary) return;
  state.stationary = now;
  if (now) {
    state.v_OS_S.setZero();
    state.w_OS_S.setZero();
    state.P.middleRows<3>(kVelocity).setZero();
    state.P.middleCols<3>(kVelocity).setZero();
    state.transition.middleRows<3>(kVelocity).setZero();
    state.correction_rate.setZero();
  } else {
    // What moved before it was noticed: the wheels measure the way anew from the clone. A gyro that
    // notices by itself missed nothing; else it was below the limit for at most a wheel period.
    state.way_unmeasured = true;
    if (!ImuAlive(state)) state.yaw_unmeasured = true;
    state.P(0, 0) += Square(kUnnoticedWay);
    state.correction_rate(0, 0) += Square(kUnnoticedWay) / kCorrectionMemory;
    if (!ImuAlive(state) || state.imu_still_since < utime) {
      state.P(5, 5) += Square(kUnnoticedTurn);
      state.correction_rate(5, 5) += Square(kUnnoticedTurn) / kCorrectionMemory;
    }
    state.P.diagonal().segment<3>(kVelocity) += Vector3d(1e-2, 1e-4, 1e-4);
  }
}

void DrModel::ApplyZeroMotion(double dt, FilterState& state) const {
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 3>(0, kGyroBias) = R_BI_;
  Update<3>(H, state.gyro_B - R_BI_ * state.gyro_bias,
            Matrix3d::Identity() * (Square(imu_.gyro_noise) / dt), PoseUpdate::kHold, state);
  if (!state.imu_has_accel || !state.aligned) return;
  const Vector3d up_S = state.T_OS.rotation().conjugate() * kUp;
  H.setZero();
  H.block<3, 3>(0, 3) = Skew(up_S);
  H.block<3, 3>(0, kAccelBias) = R_BI_;
  Update<3>(H, state.accel_B - R_BI_ * state.accel_bias - up_S,
            Matrix3d::Identity() * (Square(imu_.accel_noise) / dt + Square(0.01)),
            PoseUpdate::kHold, state);
}

}  // namespace gw::dr_ekf

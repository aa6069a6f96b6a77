#include "dr_ekf/core/dr_model.h"

#include <algorithm>
#include <cmath>

#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/levelled.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

DrModel::DrModel(const DrEkfConfig& config, const Calibration& calibration)
    : config_(config), imu_(calibration.imu), wheel_(calibration.wheel) {
  R_BI_ = imu_.T_BI.rotation().toRotationMatrix();
  if (imu_.present && imu_.has_accel) {
    T_BS_ = SE3(Eigen::Quaterniond::Identity(), imu_.T_BI.translation());
  }
  T_SB_ = T_BS_.inverse();
  adj_BS_ = T_BS_.Adjoint();
  tick_m_ = 1.0 / wheel_.ticks_per_metre;
  wheel_period_s_ = 1.0 / wheel_.rate_hz;
  imu_cover_ = std::max(DurationFromSeconds(3.0 / imu_.rate_hz), Milliseconds(40));
  imu_timeout_ = DurationFromSeconds(3.0 / imu_.rate_hz) + Milliseconds(100);
  wheel_timeout_ = DurationFromSeconds(3.0 / wheel_.rate_hz) + Milliseconds(250);
}

FilterState DrModel::Initial(Utime utime) const {
  FilterState state;
  state.utime = utime;
  state.T_OS = T_BS_;
  Vector6d pose_B = Vector6d::Zero();
  if (!(imu_.present && imu_.has_accel)) pose_B[3] = pose_B[4] = Square(kFloorTilt);
  const Matrix6d adj_SB = T_SB_.Adjoint();
  state.P.block<6, 6>(kPose, kPose) = adj_SB * pose_B.asDiagonal() * adj_SB.transpose();
  state.P(kVelocity, kVelocity) = Square(kForwardSpeedPrior);
  state.P(kVelocity + 1, kVelocity + 1) = Square(kSidewaysSpeedPrior);
  state.P(kVelocity + 2, kVelocity + 2) = Square(kSidewaysSpeedPrior);
  if (imu_.present) {
    state.P.block<3, 3>(kGyroBias, kGyroBias).diagonal().setConstant(Square(kGyroBiasPrior));
    state.P.block<3, 3>(kGyroScale, kGyroScale)
        .diagonal()
        .setConstant(Square(config_.gyro_scale_sigma));
    if (imu_.has_accel) {
      state.P.block<3, 3>(kAccelBias, kAccelBias).diagonal().setConstant(Square(kAccelBiasPrior));
    }
  }
  if (wheel_.present) {
    state.P(kWheelScale, kWheelScale) = Square(config_.wheel_scale_sigma);
    state.P(kYawScale, kYawScale) = Square(
        imu_.present && config_.wheel_scale_sigma > 0 ? kYawScalePrior : config_.wheel_scale_sigma);
    if (config_.wheel_scale_sigma > 0) {
      state.P(kTurnPerWay, kTurnPerWay) = Square(kUnequalWheels / wheel_.track_width_m);
    }
    if (imu_.present && imu_.has_accel) {
      state.P(kClimb, kClimb) = state.P(kCrab, kCrab) = Square(kAskewPrior);
      state.P(kTurnCentre, kTurnCentre) = Square(kTurnCentrePrior);
    }
  }
  return state;
}

FilterState DrModel::Restarted(const FilterState& before, Utime utime) const {
  FilterState state = Initial(utime);
  state.reset_counter = before.reset_counter + 1;
  state.counters = before.counters;
  if (!before.T_OS.IsFinite() || !before.P.allFinite()) return state;
  state.T_OS = before.T_OS;
  state.wheel_scale = before.wheel_scale;
  state.yaw_scale = before.yaw_scale;
  state.turn_per_way = before.turn_per_way;
  state.climb = before.climb;
  state.crab = before.crab;
  state.turn_centre = before.turn_centre;
  state.accel_noise = before.accel_noise;
  state.turn_noise = before.turn_noise;
  state.heading_stuck = before.heading_stuck;
  state.stamp_error = before.stamp_error;
  state.floor = (state.T_OS * T_SB_.translation()).z();
  state.P.block<6, 6>(kPose, kPose) = before.P.block<6, 6>(kPose, kPose);
  // Unknown motion: it may be anywhere near and face anywhere.
  state.P.block<3, 3>(0, 0).diagonal().array() += 1.0;
  state.P(5, 5) += 1.0;
  for (const int of_wheels : {kWheelScale, kYawScale, kTurnPerWay, kClimb, kCrab, kTurnCentre}) {
    state.P(of_wheels, of_wheels) = before.P(of_wheels, of_wheels);
  }
  if (!imu_.present) return state;
  state.gyro_bias = before.gyro_bias;
  state.accel_bias = before.accel_bias;
  state.gyro_scale = before.gyro_scale;
  state.aligned = before.aligned;
  if (state.aligned) {
    state.P(3, 3) += Square(kTiltPrior);
    state.P(4, 4) += Square(kTiltPrior);
  }
  for (const int block : {kGyroBias, kAccelBias, kGyroScale}) {
    const Matrix3d known = before.P.block<3, 3>(block, block);
    state.P.block<3, 3>(block, block) = known;
  }
  return state;
}

// B before and after is the same; S was that of the IMU, and "up" came from it.
FilterState DrModel::RestartedWithoutImu(const FilterState& before, const SE3& T_OB,
                                         Utime utime) const {
  FilterState wheels = before;
  wheels.T_OS = Levelled(T_OB) * T_BS_;
  wheels.yaw_scale = 1;  // it was compared with a gyro that is not believed
  wheels.turn_per_way = 0;
  wheels.wheel_scale = 1;
  wheels.climb = wheels.crab = wheels.turn_centre = 0;
  FilterState state = Restarted(wheels, utime);
  state.P = Initial(utime).P;
  const Matrix6d pose = before.P.block<6, 6>(kPose, kPose);
  for (const int axis : {0, 1, 2, 5}) state.P(axis, axis) += 1.0 + pose(axis, axis);
  return state;
}

Vector3d DrModel::Rate(const Vector3d& gyro_B, const FilterState& state) const {
  return R_BI_ * state.gyro_scale.cwiseProduct(R_BI_.transpose() * gyro_B - state.gyro_bias);
}

bool DrModel::WheelsAlive(const FilterState& state) const {
  return state.has_wheel && state.utime - state.wheel_utime <= wheel_timeout_;
}

bool DrModel::ImuAlive(const FilterState& state) const {
  return state.has_imu && state.utime - state.imu_utime <= imu_timeout_;
}

void DrModel::ApplyImu(const ImuSample& imu, FilterState& state) const {
  const double dt = state.has_imu ? (imu.utime - state.imu_utime).seconds() : 0.0;
  // Before the step, which may be the first of a motion.
  UpdateImuStillness(imu, state);
  if (state.stationary) UpdateStationary(imu.utime, state);
  PropagateTo(imu.utime, &imu, state);
  state.has_imu = true;
  state.imu_utime = imu.utime;
  state.imu_has_accel = imu.has_accel && imu_.has_accel;
  state.gyro_B = R_BI_ * imu.w_I_rad_s;
  state.accel_B = R_BI_ * imu.a_I_m_s2;
  if (!state.stationary) {
    state.w_OS_S = Rate(state.gyro_B, state);
    if (!state.aligned) state.w_OS_S.head<2>().setZero();
  }
  if (state.imu_has_accel && !state.aligned) Align(imu, state);
  UpdateStationary(imu.utime, state);
  EndSlip(state);
  // Samples of one burst may share a step of microseconds; their noise is that of the rate.
  const double noise_dt = std::clamp(dt, 0.5 / imu_.rate_hz, 2.0 / imu_.rate_hz);
  if (state.leveling) {
    if (imu.utime > state.leveling_end ||
        state.imu_still_since > state.leveling_end - Milliseconds(config_.stationary_ms)) {
      state.leveling = false;
    } else {
      Level(state);
    }
  }
  if (state.stationary) {
    ApplyZeroMotion(noise_dt, state);
  } else if (state.aligned && !WheelsAlive(state) && !state.wheel_drop) {
    ApplySpeedPrior(noise_dt, state);
  }
}

void DrModel::ApplyWheelBegin(Utime utime, FilterState& state) const {
  PropagateTo(utime, nullptr, state);
  if (state.has_clone && state.clone_utime == utime) return;  // an interval has ended here
  BeginSum(SumCovariance(false, state), state);
  ClonePose(utime, state);
}

void DrModel::ApplyWheel(const WheelSample& sample, FilterState& state) const {
  state.wheel_drop = sample.contact.wheel_drop;
  const bool not_heard = state.wheels_stand && sample.dx_m == 0 && sample.dy_m == 0 &&
                         sample.dyaw_rad == 0 &&
                         sample.utime - state.imu_still_since < DurationFromSeconds(kSteadyRateFor);
  if (state.wheel_drop || not_heard) {
    // Wheels in the air, and wheels that nobody hears, say nothing of the floor: as if silent.
    state.counters.wheel_drops += state.wheel_drop;
    state.wheel_still = false;
    UpdateStationary(sample.utime, state);
    PropagateTo(sample.utime, nullptr, state);
    FlagSlip(sample.utime, 0, state);
    state.has_heading = false;
    ClonePose(sample.utime, state);
    return;
  }
  UpdateWheelStillness(sample, state);
  if (!state.wheel_still && state.stationary) UpdateStationary(sample.utime, state);
  PropagateTo(sample.utime, nullptr, state);
  EndSlip(state);
  state.has_wheel = true;
  state.wheel_utime = sample.utime;
  state.scale_untold =
      state.stamp_error.Variance(wheel_period_s_) > Square(kMostTimeError * wheel_period_s_);
  if (!state.stationary && state.has_clone && state.clone_utime == sample.utime_begin) {
    BeginSum(SumCovariance(sample.has_ticks, state), state);
    UpdateYaw(sample, state);
    UpdateWay(sample, state);
  }
  state.has_heading = sample.has_heading;
  state.heading = sample.heading_rad;
  ClonePose(sample.utime, state);
  UpdateStationary(sample.utime, state);
}

}  // namespace gw::dr_ekf

// DrModel: from one instant to the next with the rates of the IMU, or with what a wheeled robot is
// taken to do without one.
#include <algorithm>
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Where nothing tells "up", a floor does. A tilt is there where the accelerometer that told it
// turned out to be unfit; no gyro tells of its end, so that it goes no faster than floors tilt.
Eigen::Quaterniond Levelling(double way, const FilterState& state) {
  const Vector3d up_S = state.T_OS.rotation().conjugate() * Vector3d::UnitZ();
  const Vector3d tilt(-up_S.y(), up_S.x(), 0);
  const double most = kFloorTilt * way / kFloorTiltWay;
  return ExpSO3(std::min(1.0, most / std::max(tilt.norm(), 1e-12)) * tilt);
}

}  // namespace

DrModel::Rates DrModel::RatesBetween(Utime from, Utime to, const ImuSample* imu,
                                     const FilterState& state) const {
  Rates rates;
  rates.w = Vector3d(0, 0, state.w_OS_S.z());
  if (!state.has_imu || to - state.imu_utime > imu_cover_) return rates;
  Vector3d w = state.gyro_B;
  Vector3d a = state.accel_B;
  bool has_accel = state.imu_has_accel;
  if (imu != nullptr && to > state.imu_utime) {
    // From sample to sample the integral is that of the line between them (trapezoid). Where other
    // events lie between, the way to the last of them went with the sample before, as the next one
    // was not there yet; this step makes up for it. Else a shock that lies there is lost in part:
    // of a change of speed by 0.4 m/s within one sample, a quarter.
    const double f = 0.5 * (to - state.imu_utime).seconds() / (to - from).seconds();
    w += f * (R_BI_ * imu->w_I_rad_s - w);
    a += f * (R_BI_ * imu->a_I_m_s2 - a);
    has_accel = has_accel && imu->has_accel;
  }
  rates.gyro = true;
  rates.w = Rate(w, state);
  if (!state.aligned) rates.w.head<2>().setZero();  // taken to stand flat
  if (has_accel && state.aligned) {
    rates.accel = true;
    rates.a = a - R_BI_ * state.accel_bias;
  }
  return rates;
}

void DrModel::PropagateTo(Utime utime, const ImuSample* imu, FilterState& state) const {
  if (utime <= state.utime) return;
  const double dt = (utime - state.utime).seconds();
  state.correction_rate *= std::exp(-dt / kCorrectionMemory);
  state.recent_slips *= std::exp(-dt / kSlipsMemory);
  state.recent_stands *= std::exp(-dt / kSlipsMemory);
  if (state.stationary) {
    Hold(dt, state);
  } else {
    Integrate(RatesBetween(state.utime, utime, imu, state), dt, state);
  }
  state.utime = utime;
}

void DrModel::Hold(double dt, FilterState& state) const {
  state.P.diagonal().segment<6>(kPose).array() += kPoseFloor * dt;
  state.P.diagonal().segment<3>(kGyroBias).array() += Square(imu_.gyro_walk) * dt;
  if (imu_.has_accel) {
    state.P.diagonal().segment<3>(kAccelBias).array() += Square(imu_.accel_walk) * dt;
  }
}

// How the state itself moves in a step.
DrModel::Step DrModel::StepOf(const Rates& rates, double dt, const FilterState& state) const {
  const Vector3d& v = state.v_OS_S;
  Step step;
  // Velocity without accelerometer: constant while wheels will tell, else it fades.
  const double forward =
      WheelsAlive(state) || rates.accel ? 1.0 : std::exp(-dt / kUnmeasuredSpeedMemory);
  const double side = rates.accel ? 1.0 : std::exp(-dt / kLateralCorrelation);
  step.fade = Vector3d(forward, side, side);
  if (rates.accel) {
    const Matrix3d R_OS = state.T_OS.rotation().toRotationMatrix();
    const Eigen::Quaterniond q_step = ExpSO3(rates.w * dt);
    const Vector3d a_S = ExpSO3(0.5 * dt * rates.w) * rates.a - R_OS.transpose() * kUp;
    step.T = SE3(q_step, v * dt + 0.5 * a_S * dt * dt);
    step.v_after = q_step.conjugate() * (v + a_S * dt);
  } else {
    Vector6d twist;
    twist << v, rates.w;
    step.T = SE3::Exp(twist * dt);
    if (!state.aligned) step.T = step.T * SE3(Levelling(v.norm() * dt, state), Vector3d::Zero());
    step.v_after = v.cwiseProduct(step.fade);
  }
  return step;
}

// How the error moves: continuous A, second order in the step; the pose block is exact.
TopTransition DrModel::TransitionOf(const Rates& rates, double dt, const Step& step,
                                    const FilterState& state) const {
  const Vector3d& w = rates.w;
  const Vector3d& v = state.v_OS_S;
  const Matrix3d R_OS = state.T_OS.rotation().toRotationMatrix();
  const Matrix3d R_BI = R_BI_;
  const Matrix3d gyro_to_error =
      state.aligned ? R_BI : Matrix3d(Vector3d(0, 0, 1).asDiagonal() * R_BI);
  TopTransition A = TopTransition::Zero();
  A.block<3, 3>(0, 0) = -Skew(w);
  A.block<3, 3>(0, 3) = -Skew(v);
  A.block<3, 3>(0, kVelocity).setIdentity();
  A.block<3, 3>(3, 3) = -Skew(w);
  const Matrix3d scale_to_rate = R_BI * (R_BI.transpose() * w).asDiagonal();
  if (rates.gyro) {
    A.block<3, 3>(3, kGyroBias) = -gyro_to_error;
    A.block<3, 3>(3, kGyroScale) = gyro_to_error * (R_BI.transpose() * w).asDiagonal();
  }
  if (rates.accel) {
    A.block<3, 3>(kVelocity, 3) = -Skew(R_OS.transpose() * kUp);
    A.block<3, 3>(kVelocity, kVelocity) = -Skew(w);
    A.block<3, 3>(kVelocity, kGyroBias) = -Skew(v) * R_BI;
    A.block<3, 3>(kVelocity, kGyroScale) = Skew(v) * scale_to_rate;
    A.block<3, 3>(kVelocity, kAccelBias) = -R_BI;
  }
  TopTransition F = A * dt;
  F.leftCols<9>() += Eigen::Matrix<double, 9, 9>::Identity();
  F += 0.5 * dt * dt * (A.leftCols<9>() * A);
  F.topLeftCorner<6, 6>() = step.T.inverse().Adjoint();
  if (!rates.accel) {
    F.block<3, 9>(kVelocity, 0).setZero();
    F.block<3, 3>(kVelocity, kVelocity) = step.fade.asDiagonal();
    const double tilt_rate = v.norm() / kFloorTiltWay;
    if (!state.aligned) F.middleRows<2>(3) *= std::exp(-tilt_rate * dt);
  }
  return F;
}

// White noise of pose and velocity, per second: densities of the sensors, and of what none of them
// measures.
Eigen::Matrix<double, 9, 9> DrModel::NoiseDensity(const Rates& rates,
                                                  const FilterState& state) const {
  const Vector3d& v = state.v_OS_S;
  Eigen::Matrix<double, 9, 3> G = Eigen::Matrix<double, 9, 3>::Zero();
  G.block<3, 3>(3, 0).setIdentity();
  if (rates.accel) G.block<3, 3>(kVelocity, 0) = Skew(v);
  Vector3d turn;
  if (rates.gyro) {
    turn.setConstant(Square(imu_.gyro_noise));
  } else {
    turn.setConstant(kUnmeasuredTiltDensity);
    turn.z() = 2 * Square(kUnmeasuredYawRate) * kUnmeasuredYawRateMemory;
  }
  const double tilt_rate = v.norm() / kFloorTiltWay;
  if (!state.aligned) turn.head<2>().setConstant(2 * Square(kFloorTilt) * tilt_rate);
  Eigen::Matrix<double, 9, 9> density = G * turn.asDiagonal() * G.transpose();
  if (rates.accel) {
    density.diagonal().segment<3>(kVelocity).array() += Square(imu_.accel_noise);
  } else {
    const double side = SideVariance(v.norm(), rates.w.z()) / Square(kLateralCorrelation);
    density.diagonal().segment<3>(kVelocity) +=
        Vector3d(2 * Square(kUnmeasuredSpeed) / kUnmeasuredSpeedMemory, side, side);
  }
  density.diagonal().head<6>().array() += kPoseFloor;
  return density;
}

// Biases and scales wander.
void DrModel::Wander(double dt, FilterState& state) const {
  state.P.diagonal().segment<3>(kGyroBias).array() +=
      imu_.present ? Square(imu_.gyro_walk) * dt : 0.0;
  state.P.diagonal().segment<3>(kAccelBias).array() +=
      imu_.present && imu_.has_accel ? Square(imu_.accel_walk) * dt : 0.0;
  if (config_.gyro_scale_sigma > 0 && imu_.present) {
    state.P.diagonal().segment<3>(kGyroScale).array() += Square(kScaleWalk) * dt;
  }
  if (config_.wheel_scale_sigma > 0) {
    state.P(kWheelScale, kWheelScale) += Square(kScaleWalk) * dt;
    state.P(kYawScale, kYawScale) += Square(kScaleWalk) * dt;
    state.P(kTurnPerWay, kTurnPerWay) += Square(kScaleWalk / wheel_.track_width_m) * dt;
  }
}

void DrModel::Integrate(const Rates& rates, double dt, FilterState& state) const {
  if (!rates.accel) state.way_unmeasured = true;
  if (!rates.gyro) state.yaw_unmeasured = true;
  const Step step = StepOf(rates, dt, state);
  const TopTransition F = TransitionOf(rates, dt, step, state);
  // Trapezoid over the step.
  const Eigen::Matrix<double, 9, 9> density = NoiseDensity(rates, state);
  const auto F9 = F.leftCols<9>();
  const Eigen::Matrix<double, 9, 9> noise = 0.5 * dt * (density + F9 * density * F9.transpose());
  ApplyTransition(F, state);
  state.P.topLeftCorner<9, 9>() += noise;
  Wander(dt, state);
  state.T_OS = state.T_OS * step.T;
  state.v_OS_S = step.v_after;
  state.w_OS_S = rates.w;
  const double forget = std::exp(-dt / kUsualSpeedMemory);
  state.usual_speed = forget * state.usual_speed + (1 - forget) * state.v_OS_S.norm();
}

}  // namespace gw::dr_ekf

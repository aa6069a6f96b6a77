// DrModel: what consumers get, and with it how the covariance of relative motion grows (ADR 4).
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {

using Eigen::Vector3d;

DrState DrModel::Publish(const FilterState& state) const {
  DrState out;
  out.utime = state.utime;
  out.reset_counter = state.reset_counter;
  out.T_OB = state.T_OS * T_SB_;
  out.w_OB_B = state.w_OS_S;
  out.v_OB_B = state.v_OS_S - state.w_OS_S.cross(T_BS_.translation());
  out.gyro_bias_rad_s = state.gyro_bias;
  out.accel_bias_m_s2 = state.accel_bias;
  out.wheel_scale = state.wheel_scale;
  const Matrix6d cov = adj_BS_ * state.P.block<6, 6>(kPose, kPose) * adj_BS_.transpose();
  out.cov_T_OB = 0.5 * (cov + cov.transpose());
  out.gravity_aligned = state.aligned;
  out.slip = state.slip;
  out.stationary = state.stationary;
  out.wheels_alive = WheelsAlive(state);
  out.imu_alive = ImuAlive(state);

  const bool gyro = out.imu_alive;
  if (out.wheels_alive) out.way_scale_sigma = std::sqrt(state.P(kWheelScale, kWheelScale));
  if (gyro) {
    // Of turns about z of B; a wheeled robot has hardly any others.
    const Vector3d share = R_BI_.transpose().col(2).cwiseAbs2();
    out.turn_scale = share.dot(state.gyro_scale);
    out.turn_scale_sigma =
        std::sqrt(share.dot(state.P.block<3, 3>(kGyroScale, kGyroScale) * share));
  } else if (!state.heading_used) {
    out.turn_scale = state.yaw_scale;
    out.turn_scale_sigma = std::sqrt(state.P(kYawScale, kYawScale));
  }

  out.cov_twist_white.diagonal().setConstant(kPoseFloor);
  if (state.stationary) return out;
  const double speed = out.v_OB_B.norm();
  const double rate = std::abs(out.w_OB_B.z());
  const bool accel = HasAccelerometer(state);
  // With an accelerometer the velocity's own covariance knows of a slip.
  const double slip = state.slip && !accel ? kSlipVarianceFactor : 1.0;
  Vector6d white = Vector6d::Zero();
  Matrix6d& C = out.cov_twist_coherent;

  const double side = SideVariance(speed, rate);
  if (out.wheels_alive) {
    white.head<3>() << WayVariance(speed) * slip, side * slip, side;
    if (state.slip && accel) C.block<2, 2>(0, 0) = state.P.block<2, 2>(kVelocity, kVelocity);
    white[0] += Square(state.speed_doubt) * 2 * kSlipHold;  // lasts for about as long
  } else {
    C.block<3, 3>(0, 0) = state.P.block<3, 3>(kVelocity, kVelocity);
    white[1] = white[2] = side;
  }
  if (state.aligned) {
    C(1, 1) +=
        Square(rate) * state.P(kTurnCentre, kTurnCentre) + Square(speed) * state.P(kCrab, kCrab);
    C(2, 2) += Square(speed) * state.P(kClimb, kClimb);
  }
  if (gyro) {
    white.tail<3>().setConstant(Square(imu_.gyro_noise));
    C.block<3, 3>(3, 3) = R_BI_ * state.P.block<3, 3>(kGyroBias, kGyroBias) * R_BI_.transpose();
  } else if (state.heading_used) {
    white[5] = Square(kHeadingSigmaPerSqrtS) + Square(kHeadingSigmaPerSqrtRad) * rate;
    C(5, 5) = Square(kHeadingDrift);
  } else {
    white[5] = WheelYawVariance(speed, rate) * (state.slip ? kSlipVarianceFactor : 1.0);
    C(5, 5) = Square(state.usual_speed) * state.P(kTurnPerWay, kTurnPerWay);
  }
  if (!state.aligned) {
    white[3] = white[4] = 2 * Square(kFloorTilt) * speed / kFloorTiltWay;
    C.row(3).setZero();
    C.row(4).setZero();
    C.col(3).setZero();
    C.col(4).setZero();
  } else if (!gyro) {
    white[3] = white[4] = kUnmeasuredTiltDensity;
  }
  out.cov_twist_white.diagonal() += white;
  out.cov_twist_white += adj_BS_ * state.correction_rate * adj_BS_.transpose();
  return out;
}

}  // namespace gw::dr_ekf

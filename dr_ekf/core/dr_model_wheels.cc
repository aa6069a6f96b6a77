// DrModel: how good the wheels are: noise that adds up with the way, and errors of the sums that do
// not (docs/adr/0017-wheels-as-sums.md).
#include <algorithm>
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {

using Eigen::Vector3d;

void DrModel::ApplySpeedPrior(double dt, FilterState& state) const {
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 3>(0, kVelocity).setIdentity();
  const Vector3d v_B = state.v_OS_S - state.w_OS_S.cross(T_BS_.translation());
  const double side = SideVariance(v_B.norm() + kLeastSpeed, state.w_OS_S.z()) / dt;
  const Vector3d variance(2 * Square(kSpeedPrior) * kSpeedPriorMemory / dt, side, side);
  Update<3>(H, -v_B, variance.asDiagonal(), PoseUpdate::kCorrect, state);
}

double DrModel::WayVariance(double way) const {
  return Square(config_.wheel_sigma_m_per_sqrt_m) * std::abs(way);
}

double DrModel::SideVariance(double way, double turn) const {
  const double tyre_way = std::abs(way) + 0.5 * wheel_.track_width_m * std::abs(turn);
  return Square(config_.lateral_sigma_m_per_sqrt_m) * tyre_way;
}

double DrModel::WheelYawVariance(double way, double yaw) const {
  return Square(config_.wheel_sigma_deg_per_sqrt_m * kRadPerDeg) * std::abs(way) +
         Square(config_.wheel_sigma_deg_per_sqrt_rad * kRadPerDeg) * std::abs(yaw);
}

SE3 DrModel::MotionSinceClone(const FilterState& state) const {
  return T_BS_ * state.T_OS_clone.inverse() * state.T_OS * T_SB_;
}

// How wrong the speed may be when the wheels turned this much too far: one of them did it alone.
double DrModel::TrackSpeed(double yaw, double dt) const {
  return 0.5 * wheel_.track_width_m * std::abs(yaw) / dt;
}

Eigen::Vector2d DrModel::Speeds(const FilterState& state) const {
  const Vector3d v_B = state.v_OS_S - state.w_OS_S.cross(T_BS_.translation());
  return {v_B.x(), state.w_OS_S.z()};
}

Eigen::Matrix2d DrModel::SumCovariance(bool has_ticks, const FilterState& state) const {
  const Eigen::Vector2d speeds = Speeds(state);
  Eigen::Matrix2d cov = state.stamp_error.Variance(wheel_period_s_) * speeds * speeds.transpose();
  cov(0, 0) += Square(kWayFloor) / 2;
  cov(1, 1) += Square(kYawFloor) / 2;
  if (has_ticks) {
    // A reading is anywhere within its tick: variance of an even distribution, of the mean of two
    // wheels and of their difference.
    cov(0, 0) += Square(tick_m_) / 24;
    cov(1, 1) += Square(tick_m_ / wheel_.track_width_m) / 6;
  }
  return cov;
}

void DrModel::DoubtSum(int sum, double innovation, const Eigen::Matrix<double, 1, kErrorSize>& H,
                       double noise, FilterState& state) const {
  const double expected = (H * state.P * H.transpose())(0) + noise;
  state.P(kNewSum + sum, kNewSum + sum) += std::max(0.0, Square(innovation) - expected);
}

double DrModel::SumError(int sum, const FilterState& state) const {
  return state.stamp_error.SizeVariance(wheel_period_s_) * Square(Speeds(state)[sum]) +
         Square(sum == 0 ? kWayFloor : kYawFloor);
}

double DrModel::LargestTimeError(int sum, double dt, const FilterState& state) const {
  double time = std::max(dt, wheel_period_s_);
  if (state.stamp_error.known()) {
    time = std::min(
        time, config_.gate_sigma * std::sqrt(2 * state.stamp_error.SizeVariance(wheel_period_s_)));
  }
  return std::abs(Speeds(state)[sum]) * time;
}

}  // namespace gw::dr_ekf

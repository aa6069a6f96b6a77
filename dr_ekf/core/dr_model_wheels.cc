// DrModel: a wheel sample as a measurement of the motion over its interval.
#include <algorithm>
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Variance that stands for "knows nothing" of a motion since the clone: far above any measurement,
// low enough that the update keeps 14 digits.
constexpr double kUnknownVariance = 1.0;
// Wheels at rest still let the body rock by this much between two samples.
constexpr double kWayFloor = 1e-4;  // m
constexpr double kYawFloor = 1e-4;  // rad

}  // namespace

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

void DrModel::UpdateYaw(const WheelSample& sample, FilterState& state) const {
  const double dt = (sample.utime - sample.utime_begin).seconds();
  const double way = std::hypot(sample.dx_m, sample.dy_m);
  const SE3 T_ab = MotionSinceClone(state);
  const Vector3d angle = LogSO3(T_ab.rotation());
  const double quantisation = sample.has_ticks ? Square(tick_m_ / wheel_.track_width_m) / 3.0 : 0.0;
  // Where the filter sees the motion by itself, size of the noise and sensitivity to the scale come
  // from there. Taken from the noisy sample they would correlate with its noise: readings that are
  // small by chance would count more, and biases and scales would be pulled to a false value.
  const double turn = state.yaw_unmeasured ? sample.dyaw_rad : angle.z() / state.yaw_scale;
  double wheel_variance = WheelYawVariance(way, turn) + quantisation + Square(kYawFloor);

  const bool use_heading = state.yaw_unmeasured && sample.has_heading && state.has_heading;
  state.heading_used = use_heading;
  Eigen::Matrix<double, 1, kErrorSize> H = Eigen::Matrix<double, 1, kErrorSize>::Zero();
  H.block<1, 3>(0, kPose + 3) = Eigen::RowVector3d::UnitZ();
  H.block<1, 3>(0, kClone + 3) = -T_ab.rotation().conjugate().toRotationMatrix().row(2);
  const double wheel_yaw = state.yaw_scale * sample.dyaw_rad;
  using Scalar = Eigen::Matrix<double, 1, 1>;

  if (state.yaw_unmeasured) {
    double yaw = wheel_yaw;
    double variance = wheel_variance;
    if (use_heading) {
      yaw = WrapAngle(sample.heading_rad - state.heading);
      variance = Square(kHeadingSigmaPerSqrtS) * dt +
                 Square(kHeadingSigmaPerSqrtRad) * std::abs(yaw) + Square(kHeadingStep) / 6.0;
      const double scale_variance = Square(sample.dyaw_rad) * state.P(kYawScale, kYawScale);
      if (Square(yaw - wheel_yaw) >
          Square(config_.gate_sigma) * (wheel_variance + variance + scale_variance)) {
        ++state.counters.gated_wheel_yaw;
        FlagSlip(sample.utime, TrackSpeed(yaw - wheel_yaw, dt), state);
      }
    } else {
      if (std::abs(yaw / dt - state.w_OS_S.z()) >
          config_.max_acceleration_m_s2 / (0.5 * wheel_.track_width_m) * dt +
              config_.gate_sigma * std::sqrt(2 * variance) / dt) {
        FlagSlip(sample.utime, TrackSpeed(yaw - state.w_OS_S.z() * dt, dt), state);
      }
      if (state.slip) variance = kSlipVarianceFactor * variance + Square(kSlipYawShare * yaw);
      H[kYawScale] = -sample.dyaw_rad;
    }
    state.P(5, 5) += kUnknownVariance;
    Update<1>(H, Scalar(WrapAngle(yaw - angle.z())), Scalar(variance), PoseUpdate::kDefineTurn,
              state);
    state.w_OS_S = Vector3d(0, 0, yaw / dt);
    return;
  }

  H[kYawScale] = -turn;
  const double residual = WrapAngle(wheel_yaw - angle.z());
  const double variance = (H * state.P * H.transpose())(0) + wheel_variance;
  const bool was_rejecting = state.yaw_gate.rejecting;
  const double excess = state.yaw_gate.Judge(residual, variance, config_.gate_sigma, kLeastSlipTurn,
                                             sample.utime_begin, dt);
  if (excess > 1) {
    ++state.counters.gated_wheel_yaw;
    if (!state.yaw_gate.rejecting) return;
    state.rejected_yaw = residual + (was_rejecting ? state.rejected_yaw : 0.0);
    const DurationUs rejecting =
        sample.utime - state.yaw_gate.rejecting_since + DurationFromSeconds(dt);
    const double rate = state.rejected_yaw / rejecting.seconds();
    if (rejecting <= DurationFromSeconds(kMaxYawRejection) || std::abs(rate) >= kMaxBiasJump) {
      FlagSlip(sample.utime, TrackSpeed(residual, dt), state);
      return;
    }
    ++state.counters.gyro_bias_jumps;
    state.P.diagonal().segment<3>(kGyroBias).array() += Square(kGyroBiasPrior) + Square(rate);
    state.yaw_gate = {};
  }
  if (state.slip) wheel_variance *= kSlipVarianceFactor;
  Update<1>(H, Scalar(residual), Scalar(wheel_variance), PoseUpdate::kCorrect, state);
}

void DrModel::UpdateWay(const WheelSample& sample, FilterState& state) const {
  const double dt = (sample.utime - sample.utime_begin).seconds();
  const SE3 T_ab = MotionSinceClone(state);
  const Vector3d angle = LogSO3(T_ab.rotation());
  const Eigen::Quaterniond half_back = ExpSO3(-0.5 * angle);

  // In the heading halfway through the interval the way of a rolling robot is straight ahead, for
  // the wheels as for the filter, even where their yaw differs.
  const Vector3d way_measured = Eigen::AngleAxisd(-0.5 * sample.dyaw_rad, Vector3d::UnitZ()) *
                                Vector3d(sample.dx_m, sample.dy_m, 0);
  const Vector3d way_filter = half_back * T_ab.translation();
  const Vector3d way = state.wheel_scale * way_measured;
  const double length = way_measured.norm();

  // Derivative of way_filter with the motion since the clone, then with both poses.
  Eigen::Matrix<double, 3, 6> J;
  J << (half_back * T_ab.rotation()).toRotationMatrix(), 0.5 * Skew(way_filter);
  Eigen::Matrix<double, 3, kErrorSize> H = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  H.block<3, 6>(0, kPose) = J * adj_BS_;
  H.block<3, 6>(0, kClone) = -J * T_ab.inverse().Adjoint() * adj_BS_;

  const auto variance_of = [&](double driven) {
    const double side = SideVariance(driven, angle.z());
    Vector3d out(WayVariance(driven), side, side);
    out.array() += Square(kWayFloor);
    if (sample.has_ticks) out.x() += Square(tick_m_) / 12.0;
    return out;
  };
  // Sensitivity to the scale, and size of the noise: neither from the sample nor from the
  // prediction, whose errors are in the innovation (see UpdateYaw; the scale would come out 1 %
  // too large here), but from the two combined, whose error the innovation does not hold. Sideways
  // the wheels' own (rolling) way is free of noise.
  Vector3d sensitivity = way_measured;
  if (!state.way_unmeasured) {
    const double predicted = (H.row(0) * state.P * H.row(0).transpose())(0);
    const double share = predicted / (predicted + variance_of(way_filter.x()).x());
    sensitivity.x() = (way_filter.x() + share * (way.x() - way_filter.x())) / state.wheel_scale;
  }
  Vector3d variance = variance_of(state.way_unmeasured ? length : sensitivity.x());
  H.col(kWheelScale) = -sensitivity;

  if (!state.way_unmeasured) {
    const Matrix3d S = H * state.P * H.transpose() + Matrix3d(variance.asDiagonal());
    const Vector3d residual = way - way_filter;
    const double excess_up = Square(residual.z()) / (Square(config_.gate_sigma) * S(2, 2));
    if (excess_up > 1) variance.z() += excess_up * S(2, 2);  // a bump, not slip
    if (state.slip) variance.head<2>() *= kSlipVarianceFactor;
    for (const int axis : {0, 1}) {
      if (!AcceptWay(axis, way[axis], residual[axis], S(axis, axis), dt, state)) {
        variance[axis] = kUnknownVariance;
      }
    }
    Update<3>(H, residual, variance.asDiagonal(), PoseUpdate::kDefineWay, state);
    return;
  }

  const Vector3d arm = T_BS_.translation();
  const Vector3d v_before = state.v_OS_S - state.w_OS_S.cross(arm);
  const Vector3d v_now = way / dt;
  const double jump = (v_now - v_before).head<2>().norm();
  if (jump >
      config_.max_acceleration_m_s2 * dt + config_.gate_sigma * std::sqrt(2 * variance.x()) / dt) {
    FlagSlip(sample.utime, jump, state);
  }
  if (state.slip) {
    variance.head<2>() *= kSlipVarianceFactor;
    variance.x() += Square(state.speed_doubt) * 2 * kSlipHold * dt;  // coherent for as long
  }
  state.P.diagonal().head<3>().array() += kUnknownVariance;
  Update<3>(H, way - way_filter, variance.asDiagonal(), PoseUpdate::kDefineWay, state);
  // The velocity is that of the interval.
  state.v_OS_S = v_now + state.w_OS_S.cross(arm);
  const Eigen::Matrix<double, 3, kErrorSize> scale_rows =
      (way_measured / dt) * state.P.row(kWheelScale);
  const Eigen::Matrix<double, 3, kErrorSize> scale_map =
      (way_measured / dt) * state.transition.row(kWheelScale);
  state.P.middleRows<3>(kVelocity) = scale_rows;
  state.P.middleCols<3>(kVelocity) = scale_rows.transpose();
  state.P.block<3, 3>(kVelocity, kVelocity) =
      (way_measured / dt) * (way_measured / dt).transpose() * state.P(kWheelScale, kWheelScale) +
      Matrix3d(variance.asDiagonal()) / (dt * dt);
  state.transition.middleRows<3>(kVelocity) = scale_map;
}

}  // namespace gw::dr_ekf

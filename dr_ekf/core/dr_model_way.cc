// DrModel: the way of the wheels over an interval as a measurement.
#include <algorithm>
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Eigen::Vector3d;

// Variance that stands for "knows nothing" of a way since the clone: far above any measurement, low
// enough that the update keeps 14 digits.
constexpr double kUnknownWay = 100;  // m^2

}  // namespace

DrModel::WayInnovation DrModel::InnovateWay(const WheelSample& sample,
                                            const FilterState& state) const {
  WayInnovation in;
  in.dt = (sample.utime - sample.utime_begin).seconds();
  const SE3 T_ab = MotionSinceClone(state);
  const Vector3d angle = LogSO3(T_ab.rotation());
  const Eigen::Quaterniond half_back = ExpSO3(-0.5 * angle);
  // In the heading halfway through the interval the way of a rolling robot is straight ahead, for
  // the wheels as for the filter, even where their yaw differs.
  in.measured = Eigen::AngleAxisd(-0.5 * sample.dyaw_rad, Vector3d::UnitZ()) *
                Vector3d(sample.dx_m, sample.dy_m, 0);
  const Vector3d own = half_back * T_ab.translation();
  in.way = state.wheel_scale * in.measured;
  const double arc = 2 * std::sin(0.5 * angle.z());
  if (state.aligned) {
    // The point that rolls straight ahead is not the origin of B, nor is their "ahead" its x.
    in.way.z() = state.climb * in.way.x();
    in.way.y() += state.crab * in.way.x() - arc * state.turn_centre;
  }
  in.residual = in.way - own;

  // Derivative of the filter's own way with the motion since the clone, then with both poses.
  Eigen::Matrix<double, 3, 6> J;
  J << (half_back * T_ab.rotation()).toRotationMatrix(), 0.5 * Skew(own);
  in.H.setZero();
  in.H.block<3, 6>(0, kPose) = J * adj_BS_;
  in.H.block<3, 6>(0, kClone) = -J * T_ab.inverse().Adjoint() * adj_BS_;

  const auto noise_of = [&](double driven) {
    const double side = SideVariance(driven, angle.z()) + Square(kWayFloor);
    return Vector3d(WayVariance(driven), side, side);
  };
  // Sensitivity to the scale, and size of the noise: as the filter has the way, not as the sample
  // has it, whose noise is in the innovation as well and would tell of the scale, always to the
  // same side. Sideways the wheels' own (rolling) way is free of noise.
  Vector3d sensitivity = in.measured;
  if (!state.way_unmeasured) sensitivity.x() = own.x() / state.wheel_scale;
  in.noise = noise_of(state.way_unmeasured ? in.measured.norm() : sensitivity.x());
  in.H.col(kWheelScale) = -sensitivity;
  if (state.aligned) {
    in.H(2, kClimb) = in.H(1, kCrab) = -state.wheel_scale * sensitivity.x();
    in.H(1, kTurnCentre) = arc;
  }
  in.H(0, kNewSum) = 1;
  in.H(0, kCloneSum) = -1;
  return in;
}

void DrModel::UpdateWay(const WheelSample& sample, FilterState& state) const {
  const WayInnovation in = InnovateWay(sample, state);
  if (!state.way_unmeasured) {
    CorrectWay(in, state);
  } else {
    DefineWay(sample, in, state);
  }
  UpdateHeight(in.measured.norm(), state);
}

void DrModel::CorrectWay(WayInnovation in, FilterState& state) const {
  const double sums = SumError(0, state);
  const double speed = Speeds(state)[0];
  Eigen::Matrix<double, 3, kErrorSize> H_own = in.H;
  H_own.rightCols<4>().setZero();
  if (state.slip) in.noise.head<2>() *= kSlipVarianceFactor;
  const Eigen::Matrix3d own = H_own * state.P * H_own.transpose();
  const double up = own(2, 2) + in.noise.z();
  const double excess_up = Square(in.residual.z()) / (Square(config_.gate_sigma) * up);
  if (excess_up > 1) in.noise.z() += excess_up * up;  // a bump, not slip
  // Where it agrees with the wheels the accelerometer is as good as it is said to be.
  const double noise_factor =
      state.accel_noise.value() > kAgreeingNoise ? state.accel_noise.value() : 1.0;
  bool rolls = !state.slip;
  for (const int axis : {0, 1}) {
    SlipGate::Interval interval;
    interval.innovation = in.residual[axis];
    interval.variance = noise_factor * own(axis, axis) + in.noise[axis];
    interval.sum_error = axis == 0 ? sums : 0;
    interval.least = axis == 0 ? LargestTimeError(0, in.dt, state) : 0;
    interval.utime = state.utime;
    interval.dt = in.dt;
    double excess = 0;
    const SlipGate::Verdict verdict =
        JudgeWay(axis, in.way[axis], in.measured.isZero(), interval, &excess, state);
    rolls = rolls && verdict == SlipGate::Verdict::kAgrees;
    switch (verdict) {
      case SlipGate::Verdict::kAgrees:
        break;
      case SlipGate::Verdict::kOutlier:
        // Forward: a sum that is off now; what is off for good shows in the next ones.
        if (axis == 0) {
          const double known = state.new_sum[0] - state.clone_sum[0];
          DoubtSum(0, in.residual.x() - known, in.H.row(0), in.noise.x(), state);
        } else {
          in.noise[axis] += (excess - 1) * interval.variance;
        }
        break;
      case SlipGate::Verdict::kSlip:
        in.noise[axis] = kUnknownWay;
        break;
    }
  }
  if (!state.forward_gate.rejecting) state.accel_noise.Add(state.forward_gate.normalised, in.dt);
  const double raw = in.residual.x();
  in.residual.x() -= state.new_sum[0] - state.clone_sum[0];
  state.rolling_untold = !rolls;
  // Of nothing any scale makes nothing.
  if (!rolls && in.measured.isZero()) state.scale_untold = true;
  Update<3>(in.H, in.residual, in.noise.asDiagonal(), PoseUpdate::kDefineWay, state);
  state.rolling_untold = false;
  if (!state.slip) {
    state.stamp_error.Add(raw, own(0, 0) + in.noise.x(), speed, in.dt);
    WatchWay(in, sums, state);
  }
  if (ContradictsPriors(state)) state.accel_unfit = true;
}

bool DrModel::ContradictsPriors(const FilterState& state) const {
  return std::abs(state.wheel_scale - 1) > kMostPriorSigmas * config_.wheel_scale_sigma ||
         std::abs(state.crab) > kMostPriorSigmas * kAskewPrior ||
         std::abs(state.turn_centre) > kMostPriorSigmas * kTurnCentrePrior;
}

void DrModel::WatchWay(const WayInnovation& in, double sums, FilterState& state) const {
  const SE3 T_ab = MotionSinceClone(state);
  const Eigen::Quaterniond half_back = ExpSO3(-0.5 * LogSO3(T_ab.rotation()));
  SlipGate::Interval interval;
  interval.innovation = in.way.x() - (half_back * T_ab.translation()).x();
  interval.variance = WayVariance(in.way.x());
  interval.sum_error = sums;
  interval.least = std::max(kLeastSlip, LargestTimeError(0, in.dt, state));
  interval.utime = state.utime;
  interval.dt = in.dt;
  double excess = 0;
  if (state.way_watch.Judge(interval, config_.gate_sigma, &excess) != SlipGate::Verdict::kSlip) {
    return;
  }
  state.way_watch = {.memory = kWatchMemory};
  ++state.counters.parted;
  DoubtAccelerometer(0, kSpeedSlack, state);
}

void DrModel::DefineWay(const WheelSample& sample, WayInnovation in, FilterState& state) const {
  const Vector3d arm = T_BS_.translation();
  const Vector3d v_before = state.v_OS_S - state.w_OS_S.cross(arm);
  const Vector3d v_now = in.way / in.dt;
  const double sums = state.P(kNewSum, kNewSum) + state.P(kCloneSum, kCloneSum);
  const double jump = (v_now - v_before).head<2>().norm();
  const double faster = std::max(v_now.norm(), v_before.norm());
  if (jump * in.dt > config_.max_acceleration_m_s2 * Square(in.dt) +
                         config_.gate_sigma * std::sqrt(2 * in.noise.x() + sums) +
                         faster * std::max(in.dt, wheel_period_s_)) {
    FlagSlip(sample.utime, jump, state);
  }
  if (state.slip) {
    in.noise.head<2>() *= kSlipVarianceFactor;
    in.noise.x() += Square(state.speed_doubt) * 2 * kSlipHold * in.dt;  // coherent for as long
  }
  in.residual.x() -= state.new_sum[0] - state.clone_sum[0];
  state.P.diagonal().head<3>().array() += kUnknownWay;
  Update<3>(in.H, in.residual, in.noise.asDiagonal(), PoseUpdate::kDefine, state);
  // The velocity is that of the interval.
  state.v_OS_S = v_now + state.w_OS_S.cross(arm);
  const Vector3d by_scale = in.measured / in.dt;
  const Eigen::Matrix<double, 3, kErrorSize> scale_rows = by_scale * state.P.row(kWheelScale);
  state.P.middleRows<3>(kVelocity) = scale_rows;
  state.P.middleCols<3>(kVelocity) = scale_rows.transpose();
  Vector3d noise = in.noise;
  noise.x() += sums;
  state.P.block<3, 3>(kVelocity, kVelocity) =
      by_scale * by_scale.transpose() * state.P(kWheelScale, kWheelScale) +
      Eigen::Matrix3d(noise.asDiagonal()) / Square(in.dt);
  state.transition.middleRows<3>(kVelocity) = by_scale * state.transition.row(kWheelScale);
}

}  // namespace gw::dr_ekf

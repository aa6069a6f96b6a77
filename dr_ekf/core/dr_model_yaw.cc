// DrModel: the turn of the wheels over an interval as a measurement.
#include <algorithm>
#include <cmath>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;

// Variance that stands for "knows nothing" of a turn since the clone: far above any measurement,
// low enough that the update keeps 14 digits.
constexpr double kUnknownTurn = 100;  // rad^2
// A heading that stands while the other one turns this far is stuck; above the largest offset of a
// gyro. Until then the base's heading may lag by some of its steps.
constexpr double kStuckTurn = 0.3;  // rad
constexpr double kStuckRate = 0.1;  // rad/s
constexpr double kUnseenSteps = 10;

}  // namespace

DrModel::YawInnovation DrModel::InnovateYaw(const WheelSample& sample,
                                            const FilterState& state) const {
  YawInnovation in;
  in.dt = (sample.utime - sample.utime_begin).seconds();
  const double way = std::hypot(sample.dx_m, sample.dy_m);
  const SE3 T_ab = MotionSinceClone(state);
  const double angle = LogSO3(T_ab.rotation()).z();
  in.measured = state.yaw_scale * sample.dyaw_rad + state.turn_per_way * sample.dx_m;
  in.residual = WrapAngle(in.measured - angle);
  in.H.setZero();
  in.H.block<1, 3>(0, kPose + 3) = Eigen::RowVector3d::UnitZ();
  in.H.block<1, 3>(0, kClone + 3) = -T_ab.rotation().conjugate().toRotationMatrix().row(2);
  in.H[kNewSum + 1] = 1;
  in.H[kCloneSum + 1] = -1;

  // Sensitivity to the scale, and size of the noise: neither from the sample nor from the filter's
  // own turn alone, whose errors are in the innovation: readings that are small by chance would
  // count more, and biases and scales would be pulled to a false value. But from the two combined,
  // each with the weight of what it knows of the wheels' turn.
  in.turn = sample.dyaw_rad;
  if (!state.yaw_unmeasured) {
    in.predicted = (in.H.segment<6>(kPose) * state.P.block<6, 6>(kPose, kPose) *
                    in.H.segment<6>(kPose).transpose())(0) +
                   (in.H.segment<6>(kClone) * state.P.block<6, 6>(kClone, kClone) *
                    in.H.segment<6>(kClone).transpose())(0) +
                   2 * (in.H.segment<6>(kPose) * state.P.block<6, 6>(kPose, kClone) *
                        in.H.segment<6>(kClone).transpose())(0);
    in.predicted = std::max(0.0, in.predicted);
    const double own_turn = (angle - state.turn_per_way * sample.dx_m) / state.yaw_scale;
    const double own = in.predicted + Square(own_turn) * state.P(kYawScale, kYawScale);
    const double wheels = WheelYawVariance(way, own_turn) +
                          ExtraTurnVariance(own_turn, sample.dyaw_rad, state) +
                          state.P(kNewSum + 1, kNewSum + 1) + state.P(kCloneSum + 1, kCloneSum + 1);
    in.turn = own_turn + own / (own + wheels) * (sample.dyaw_rad - own_turn);
  }
  in.H[kYawScale] = -in.turn;
  in.H[kTurnPerWay] = -sample.dx_m;
  in.noise = WheelYawVariance(way, in.turn);
  if (!state.yaw_unmeasured) in.noise += ExtraTurnVariance(in.turn, sample.dyaw_rad, state);
  return in;
}

// Wheels that stand turn nothing, whatever the bias of a gyro says.
double DrModel::ExtraTurnVariance(double turn, double wheel_turn, const FilterState& state) const {
  return (state.turn_noise.value() - 1) *
         WheelYawVariance(0, std::min(std::abs(turn), std::abs(wheel_turn)));
}

bool DrModel::HeadingMayBeUsed(const WheelSample& sample, FilterState& state) const {
  if (!sample.has_heading || !state.has_heading) return false;
  if (sample.heading_rad != state.heading) {
    state.turn_without_heading = 0;
    return !state.heading_stuck;
  }
  state.turn_without_heading += sample.dyaw_rad;
  if (std::abs(state.turn_without_heading) > kStuckTurn) state.heading_stuck = true;
  return !state.heading_stuck && std::abs(state.turn_without_heading) < kUnseenSteps * kHeadingStep;
}

bool DrModel::WheelTurnMayBeUsed(const WheelSample& sample, double own_turn, double dt,
                                 FilterState& state) const {
  if (sample.dyaw_rad != 0) {
    state.turn_without_wheels = 0;
    state.wheel_turn_stuck = false;
    return true;
  }
  // Under wheels that stand, a steady rate is a bias (UpdateStationary); hands, and a robot that
  // drives without being heard, turn unevenly.
  const bool moves = sample.dx_m != 0 ||
                     sample.utime - state.imu_still_since < DurationFromSeconds(kSteadyRateFor);
  if (moves && std::abs(own_turn) > kStuckRate * dt) {
    state.turn_without_wheels += own_turn;
    if (std::abs(state.turn_without_wheels) > kStuckTurn) {
      state.wheel_turn_stuck = true;
      state.wheels_stand = state.wheels_stand || (sample.dx_m == 0 && sample.dy_m == 0);
    }
  }
  return !state.wheel_turn_stuck;
}

void DrModel::UpdateYaw(const WheelSample& sample, FilterState& state) const {
  const YawInnovation in = InnovateYaw(sample, state);
  state.heading_used = false;
  if (state.yaw_unmeasured) {
    DefineYaw(sample, in, state);
    return;
  }
  if (!WheelTurnMayBeUsed(sample, in.measured - in.residual, in.dt, state)) return;
  const YawUse use = JudgeYaw(sample, in, state);
  if (use == YawUse::kNone) return;
  const double known = state.new_sum[1] - state.clone_sum[1];
  const Scalar innovation(in.residual - known);
  if (use == YawUse::kTrack) {
    // A first turn, a base that slides: off by as much as it is.
    const double expected = (in.H * state.P * in.H.transpose())(0);
    const double noise = std::max(in.noise, Square(innovation[0]) - expected);
    Update<1>(in.H, innovation, Scalar(noise), PoseUpdate::kTrackOnly, state);
    return;
  }
  const double noise = state.slip ? in.noise * kSlipVarianceFactor : in.noise;
  Update<1>(in.H, innovation, Scalar(noise), PoseUpdate::kCorrect, state);
}

void DrModel::DefineYaw(const WheelSample& sample, const YawInnovation& in,
                        FilterState& state) const {
  Eigen::Matrix<double, 1, kErrorSize> H = in.H;
  double yaw = in.measured;
  double variance = in.noise;
  const double sums = state.P(kNewSum + 1, kNewSum + 1) + state.P(kCloneSum + 1, kCloneSum + 1);
  state.heading_used = HeadingMayBeUsed(sample, state);
  if (state.heading_used) {
    yaw = WrapAngle(sample.heading_rad - state.heading);
    variance = Square(kHeadingSigmaPerSqrtS) * in.dt +
               Square(kHeadingSigmaPerSqrtRad) * std::abs(yaw) + Square(kHeadingStep) / 6.0;
    const double scale_variance = Square(sample.dyaw_rad) * state.P(kYawScale, kYawScale) +
                                  Square(sample.dx_m) * state.P(kTurnPerWay, kTurnPerWay);
    if (Square(yaw - in.measured) >
        Square(config_.gate_sigma) * (in.noise + sums + variance + scale_variance)) {
      ++state.counters.gated_wheel_yaw;
      FlagSlip(sample.utime, TrackSpeed(yaw - in.measured, in.dt), state);
    }
    H[kYawScale] = H[kTurnPerWay] = 0;
  } else {
    const double jump = std::abs(yaw - state.w_OS_S.z() * in.dt);
    const double faster = std::max(std::abs(yaw / in.dt), std::abs(state.w_OS_S.z()));
    if (jump > config_.max_acceleration_m_s2 / (0.5 * wheel_.track_width_m) * Square(in.dt) +
                   config_.gate_sigma * std::sqrt(2 * variance + sums) +
                   faster * std::max(in.dt, wheel_period_s_)) {
      FlagSlip(sample.utime, TrackSpeed(jump, in.dt), state);
    }
    if (state.slip) variance = kSlipVarianceFactor * variance + Square(kSlipYawShare * yaw);
  }
  const double known = state.heading_used ? 0 : state.new_sum[1] - state.clone_sum[1];
  if (state.heading_used) H[kNewSum + 1] = H[kCloneSum + 1] = 0;
  state.P(5, 5) += kUnknownTurn;
  Update<1>(H, Scalar(WrapAngle(yaw - in.measured + in.residual) - known), Scalar(variance),
            PoseUpdate::kDefine, state);
  state.w_OS_S = Eigen::Vector3d(0, 0, yaw / in.dt);
}

DrModel::YawUse DrModel::JudgeYaw(const WheelSample& sample, const YawInnovation& in,
                                  FilterState& state) const {
  SlipGate::Interval interval;
  interval.innovation = in.residual;
  interval.variance = in.noise + in.predicted;
  interval.coherent[0] = in.turn * std::sqrt(state.P(kYawScale, kYawScale));
  interval.coherent[1] = sample.dx_m * std::sqrt(state.P(kTurnPerWay, kTurnPerWay));
  interval.sum_error = SumError(1, state);
  interval.least = std::max(kLeastSlipTurn, LargestTimeError(1, in.dt, state));
  interval.utime = sample.utime_begin;
  interval.dt = in.dt;
  double excess = 0;
  const SlipGate::Verdict verdict = state.yaw_gate.Judge(interval, config_.gate_sigma, &excess);
  const bool track_known = std::abs(state.yaw_scale - 1) < kOtherTrack &&
                           state.P(kYawScale, kYawScale) < Square(kKnownTrackSigma);
  if (verdict != SlipGate::Verdict::kSlip || !track_known) {
    state.turn_noise.Add(state.yaw_gate.normalised, std::abs(in.turn));
  }
  if (verdict != SlipGate::Verdict::kAgrees) ++state.counters.gated_wheel_yaw;
  // Wheels that hardly turn say so whatever their track.
  const double by_track =
      Square(sample.dyaw_rad) * std::max(state.P(kYawScale, kYawScale), Square(kOtherTrack));
  if (!track_known) {
    return by_track > in.noise + interval.sum_error ? YawUse::kTrack : YawUse::kAll;
  }
  if (verdict == SlipGate::Verdict::kAgrees) {
    if (!state.slip) WatchYaw(in, interval, state);
    return YawUse::kAll;
  }
  if (verdict == SlipGate::Verdict::kOutlier) {
    // A sum that is off now. What is off for good shows in the next ones.
    const double known = state.new_sum[1] - state.clone_sum[1];
    DoubtSum(1, in.residual - known, in.H, in.noise, state);
    return YawUse::kAll;
  }
  if (sample.utime - state.yaw_gate.rejecting_since > DurationFromSeconds(kMaxYawRejection)) {
    state.yaw_gate = {};
    DoubtTurn(state);
    return YawUse::kAll;
  }
  FlagSlip(sample.utime, TrackSpeed(in.residual, in.dt), state);
  return YawUse::kNone;
}

void DrModel::WatchYaw(const YawInnovation& in, SlipGate::Interval interval,
                       FilterState& state) const {
  const double share = R_BI_.transpose().col(2).cwiseAbs2().dot(
      state.P.block<3, 3>(kGyroBias, kGyroBias).diagonal());
  const double scale = R_BI_.transpose().col(2).cwiseAbs2().dot(
      state.P.block<3, 3>(kGyroScale, kGyroScale).diagonal());
  interval.variance = in.noise + Square(imu_.gyro_noise) * in.dt;
  interval.coherent[0] = in.turn * std::sqrt(state.P(kYawScale, kYawScale) + scale);
  interval.coherent[1] = std::hypot(interval.coherent[1], in.dt * std::sqrt(share));
  double excess = 0;
  if (state.yaw_watch.Judge(interval, config_.gate_sigma, &excess) != SlipGate::Verdict::kSlip) {
    return;
  }
  state.yaw_watch = {.memory = kWatchMemory};
  DoubtTurn(state);
}

// Gyro and wheels disagree for too long to be slip. Which of the two is wrong, what follows tells
// by its shape: a bias goes with time, a scale with the turn. Until then neither is sure.
void DrModel::DoubtTurn(FilterState& state) const {
  ++state.counters.parted;
  ++state.counters.gyro_bias_jumps;
  state.P.diagonal().segment<3>(kGyroBias).array() += Square(kGyroBiasPrior);
  if (config_.wheel_scale_sigma > 0) {
    state.P(kYawScale, kYawScale) += Square(kTrackDoubt);
  }
}

}  // namespace gw::dr_ekf

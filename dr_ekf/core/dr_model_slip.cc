// DrModel: health of the wheels. Who accuses them, who is believed, and how they are trusted again.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dr_ekf/core/dr_model.h"
#include "dr_ekf/core/error_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {

void DrModel::FlagSlip(Utime utime, double speed_doubt, FilterState& state) const {
  if (!state.slip) ++state.counters.slips;
  state.slip = true;
  state.speed_doubt = std::max(state.speed_doubt, speed_doubt);
  state.slip_end = utime + DurationFromSeconds(kSlipHold);
}

void DrModel::EndSlip(FilterState& state) const {
  if (!state.slip || state.utime <= state.slip_end) return;
  state.slip = false;
  state.speed_doubt = 0;
}

bool DrModel::HasAccelerometer(const FilterState& state) const {
  return ImuAlive(state) && state.imu_has_accel && state.aligned;
}

SlipGate::Verdict DrModel::JudgeWay(int axis, double way, bool stand,
                                    const SlipGate::Interval& interval, double* excess,
                                    FilterState& state) const {
  SlipGate& gate = axis == 0 ? state.forward_gate : state.sideways_gate;
  const bool accused = axis == 0 && state.utime <= state.accused_until;
  const bool stands = axis == 0 && stand;
  const double share = accused ? kAccusedShare : 1.0;
  SlipGate::Interval judged = interval;
  judged.least = share * std::max(judged.least, axis == 0 ? kLeastSlip : kLeastSlide);
  const bool was_rejecting = gate.rejecting;
  const SlipGate::Verdict verdict = gate.Judge(judged, share * config_.gate_sigma, excess);
  if (verdict == SlipGate::Verdict::kAgrees) return verdict;
  ++state.counters.gated_wheel_way;
  if (verdict == SlipGate::Verdict::kOutlier) return verdict;
  FlagSlip(state.utime, 0, state);
  const double wheel_speed = way / interval.dt;
  const double own_speed = (way - interval.innovation) / interval.dt;
  if (!was_rejecting) {
    gate.speed_before = own_speed;
    // Wheels that turn too far slip, and an accelerometer that finds it again and again is wrong,
    // where vision does not find it, too. Wheels that do not turn at all do not slip: they are not
    // heard, or the robot is carried.
    gate.counted = !stands && !accused;
    state.recent_stands += stands;
    state.recent_slips += gate.counted;
    if (state.recent_slips > kMostSlips) state.accel_unfit = true;
    if (state.recent_stands > kMostSlips) state.wheels_stand = true;
  }
  // Tyres pull the robot toward the wheels' speed or let it stop: its speed lies between rest, what
  // it was, and the wheels'. An accelerometer that says otherwise is the one that is wrong.
  const auto [slowest, fastest] = std::minmax({0.0, wheel_speed, gate.speed_before});
  const bool impossible =
      axis == 0 && (own_speed < slowest - kSpeedSlack || own_speed > fastest + kSpeedSlack);
  const bool for_long = state.utime - gate.rejecting_since > DurationFromSeconds(kMaxWayRejection);
  state.wheels_contradicted = state.wheels_contradicted || (for_long && accused && !stands);
  if (stands) {
    state.wheels_stand = state.wheels_stand || for_long;
  } else if (impossible || (for_long && !accused)) {
    DoubtAccelerometer(axis, interval.innovation / interval.dt, state);
  }
  return verdict;
}

void DrModel::DoubtAccelerometer(int axis, double speed_error, FilterState& state) const {
  (axis == 0 ? state.forward_gate : state.sideways_gate) = {};
  state.P(kVelocity + axis, kVelocity + axis) += Square(speed_error);
  const int tilt = axis == 0 ? 4 : 3;  // what makes gravity look like motion along the axis
  state.P(tilt, tilt) += Square(kTiltDoubt);
}

void DrModel::ApplyVerdict(const VisionVerdict& verdict, FilterState& state) const {
  if (state.stationary) return;
  if (HasAccelerometer(state)) {
    // The accelerometer decides; vision only makes it decide sooner, or lets the wheels off.
    if (!verdict.agrees) {
      state.accused_until = state.utime + DurationFromSeconds(kSlipHold);
      if (std::exchange(state.forward_gate.counted, false)) {
        state.recent_slips = std::max(0.0, state.recent_slips - 1);
      }
    } else if (state.forward_gate.rejecting && state.utime - state.forward_gate.rejecting_since >
                                                   DurationFromSeconds(kVisionAcquitsAfter)) {
      DoubtAccelerometer(0, kSpeedSlack, state);
    }
    return;
  }
  if (verdict.agrees) return;
  if (!state.slip) {
    // What went wrong before it was seen.
    const double unseen = Square(verdict.speed_excess * kVisionDelay);
    state.P(0, 0) += unseen;
    state.correction_rate(0, 0) += unseen / kCorrectionMemory;
  }
  FlagSlip(state.utime, std::abs(verdict.speed_excess), state);
}

}  // namespace gw::dr_ekf

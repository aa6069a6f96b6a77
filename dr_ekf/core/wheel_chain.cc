#include "dr_ekf/core/wheel_chain.h"

#include <algorithm>
#include <cmath>

#include "dr_ekf/core/error_state.h"

namespace gw::dr_ekf {
namespace {

// Begins are taken for the end before when they are this close: rounding of the sender.
constexpr DurationUs kBeginSlack = Milliseconds(1);
// A base may be silent for seconds and then say what it drove. Longer is no interval of a base.
constexpr DurationUs kLongest = Milliseconds(10000);
// How far a stamp may lie before the one before and still belong to the same time.
constexpr DurationUs kLargestStepBack = Milliseconds(500);

DurationUs Abs(DurationUs d) {
  return d.us < 0 ? -d : d;
}

// a, then b.
WheelSample Joined(const WheelSample& a, const WheelSample& b) {
  WheelSample out = b;
  out.utime_begin = a.utime_begin;
  const double c = std::cos(a.dyaw_rad), s = std::sin(a.dyaw_rad);
  out.dx_m = a.dx_m + c * b.dx_m - s * b.dy_m;
  out.dy_m = a.dy_m + s * b.dx_m + c * b.dy_m;
  out.dyaw_rad = a.dyaw_rad + b.dyaw_rad;
  out.contact.wheel_drop |= a.contact.wheel_drop;
  return out;
}

}  // namespace

void WheelChain::Clear() {
  end_.reset();
  used_until_.reset();
  waiting_.reset();
}

// Stamps that keep their order hide at most one period of driving.
bool WheelChain::Plausible(const WheelSample& interval) const {
  const double dt =
      (std::max(interval.utime - interval.utime_begin, DurationUs{0}) + period_).seconds();
  return std::hypot(interval.dx_m, interval.dy_m) <= config_.max_speed_m_s * dt &&
         std::abs(interval.dyaw_rad) <= config_.max_yaw_rate_deg_s * kRadPerDeg * dt &&
         interval.utime - interval.utime_begin <= kLongest;
}

WheelChain::Link WheelChain::Add(const WheelSample& sample) {
  const bool goes_on = end_ && Abs(sample.utime_begin - *end_) <= kBeginSlack &&
                       *end_ - sample.utime <= kLargestStepBack;
  if (!goes_on) {
    // Older than the chain: a late sample, or time that was set back. It stands alone.
    if (end_ && sample.utime <= *end_) {
      if (!Plausible(sample)) return {Fate::kAbsurd, sample};
      return {Fate::kReady, sample};
    }
    if (!Plausible(sample)) return {Fate::kAbsurd, sample};
    waiting_.reset();
    used_until_ = sample.utime_begin;
  }
  WheelSample interval = sample;
  if (waiting_) {
    interval = Joined(*waiting_, sample);
  } else {
    interval.utime_begin = *used_until_;
  }
  if (!Plausible(interval)) {
    if (!Plausible(sample)) {
      // No motion; the chain begins anew behind it.
      end_ = used_until_ = sample.utime;
      waiting_.reset();
      return {Fate::kAbsurd, sample};
    }
    end_ = sample.utime;
    waiting_ = interval;
    return {Fate::kWaits, interval};
  }
  end_ = sample.utime;
  if (2 * (interval.utime - interval.utime_begin).us < period_.us) {
    waiting_ = interval;
    return {Fate::kWaits, interval};
  }
  waiting_.reset();
  used_until_ = interval.utime;
  return {Fate::kReady, interval};
}

}  // namespace gw::dr_ekf

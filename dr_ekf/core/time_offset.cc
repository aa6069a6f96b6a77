#include "dr_ekf/core/time_offset.h"

#include <algorithm>
#include <cmath>

namespace gw::dr_ekf {
namespace {

// A computer's queues change in minutes.
constexpr double kMemory = 120;  // s
constexpr DurationUs kRange = DurationUs{300'000};
constexpr DurationUs kLongestInterval = DurationUs{500'000};
constexpr size_t kMostWaiting = 200;                     // a gyro that is silent
constexpr DurationUs kLongestGap = DurationUs{100'000};  // of the gyro
// Gyro and wheels tell the same turns when no more than this share of the wheels' is left over;
// what they tell on a straight way is noise, which fits best anywhere.
constexpr double kMostUnexplained = 0.1;
// Time error that every stamp is taken to have besides, as a share of its interval (see
// StampError).
constexpr double kLeastTimeError = 0.05;

}  // namespace

void TimeOffset::Forget() {
  gyro_.clear();
  waiting_.clear();
}

void TimeOffset::AddGyro(Utime utime, double rate) {
  double turn = 0;
  if (!gyro_.empty()) {
    const DurationUs dt = utime - gyro_.back().utime;
    if (dt.us <= 0) return;
    if (dt > kLongestGap) {
      Forget();
    } else {
      turn = gyro_.back().turn + 0.5 * (rate + last_rate_) * dt.seconds();
    }
  }
  last_rate_ = rate;
  gyro_.push_back({utime, turn});
  while (!waiting_.empty() && waiting_.front().end + kRange <= utime) {
    if (Use(waiting_.front())) Estimate();
    waiting_.pop_front();
  }
  const Utime needed = (waiting_.empty() ? utime - kLongestInterval : waiting_.front().begin) -
                       kRange - kLongestInterval;
  while (gyro_.size() > 2 && gyro_[1].utime < needed) gyro_.pop_front();
}

void TimeOffset::AddWheels(Utime begin, Utime end, double turn) {
  if (begin >= end || end - begin > kLongestInterval) return;
  if (waiting_.size() >= kMostWaiting) waiting_.pop_front();
  waiting_.push_back({begin, end, turn});
}

bool TimeOffset::TurnAt(Utime utime, double* turn) const {
  if (gyro_.empty() || utime < gyro_.front().utime || utime > gyro_.back().utime) return false;
  const auto after = std::lower_bound(gyro_.begin(), gyro_.end(), utime,
                                      [](const Stamped& s, Utime t) { return s.utime < t; });
  *turn = after->turn;
  if (after == gyro_.begin()) return true;
  const Stamped& before = *std::prev(after);
  const double share = (utime - before.utime).seconds() / (after->utime - before.utime).seconds();
  *turn = before.turn + share * (after->turn - before.turn);
  return true;
}

bool TimeOffset::Use(const Wheels& wheels) {
  Turns turns;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const DurationUs shift = DurationFromSeconds(i * kStep);
    double begin = 0, end = 0;
    if (!TurnAt(wheels.begin - shift, &begin) || !TurnAt(wheels.end - shift, &end)) return false;
    turns[static_cast<size_t>(i + kSteps)] = end - begin;
  }
  const double dt = (wheels.end - wheels.begin).seconds();
  const double forget = std::exp(-dt / kMemory);
  dd_ = forget * dd_ + dt * dt;
  dw_ = forget * dw_ + dt * wheels.turn;
  ww_ = forget * ww_ + wheels.turn * wheels.turn;
  slopes_ *= forget;
  spread_ *= forget;
  Weigh(turns, wheels);
  for (size_t i = 0; i < turns.size(); ++i) {
    sums_[i].gg = forget * sums_[i].gg + turns[i] * turns[i];
    sums_[i].gd = forget * sums_[i].gd + turns[i] * dt;
    sums_[i].gw = forget * sums_[i].gw + turns[i] * wheels.turn;
  }
  return true;
}

void TimeOffset::Weigh(const Turns& turns, const Wheels& wheels) {
  if (std::abs(best_) == kSteps) return;
  const auto at = static_cast<size_t>(best_ + kSteps);
  const double dt = (wheels.end - wheels.begin).seconds();
  const double slope = factor_ * (turns[at + 1] - turns[at - 1]) / (2 * kStep);
  const double residual = wheels.turn - factor_ * turns[at] - rate_ * dt;
  const double by_stamp = slope * kLeastTimeError * dt;
  slopes_ += slope * slope;
  spread_ += slope * slope * (residual * residual + by_stamp * by_stamp);
}

// Of the regression w = k g + c d at a shift.
double TimeOffset::ResidualAt(int step) const {
  const Sums& s = sums_[static_cast<size_t>(step + kSteps)];
  const double gg = s.gg - s.gd * s.gd / dd_;
  const double gw = s.gw - s.gd * dw_ / dd_;
  const double ww = ww_ - dw_ * dw_ / dd_;
  return gg > 0 && gw > 0 ? std::max(0.0, ww - gw * gw / gg) : ww;
}

void TimeOffset::Estimate() {
  int best = 0;
  double least = ResidualAt(0);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double residual = ResidualAt(i);
    if (residual < least) {
      least = residual;
      best = i;
    }
  }
  best_ = best;
  const Sums& s = sums_[static_cast<size_t>(best + kSteps)];
  const double gg = s.gg - s.gd * s.gd / dd_;
  factor_ = gg > 0 ? (s.gw - s.gd * dw_ / dd_) / gg : 0;
  rate_ = (dw_ - factor_ * s.gd) / dd_;
  offset_s_ = 0;
  sigma_s_ = kPrior;
  if (std::abs(best) == kSteps) return;  // outside the grid, or nothing turned
  const double before = ResidualAt(best - 1), after = ResidualAt(best + 1);
  const double bend = before - 2 * least + after;
  const double turned = ww_ - dw_ * dw_ / dd_;
  if (bend <= 0 || slopes_ <= 0 || least > kMostUnexplained * turned) return;
  const double shift = kStep * (best + 0.5 * (before - after) / bend);
  // Residuals of neighbouring intervals err against each other where stamps jitter, which would
  // halve the variance, and alike where tyres slide, which would double it.
  const double variance = spread_ / (slopes_ * slopes_);
  const double share = kPrior * kPrior / (kPrior * kPrior + variance);
  offset_s_ = share * shift;
  sigma_s_ = std::sqrt(share * variance);
}

}  // namespace gw::dr_ekf

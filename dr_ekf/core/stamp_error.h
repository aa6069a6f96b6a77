// How wrong the stamps of the wheels' samples are: jitter, lateness, resampling.
//
// A sum of the wheels that is stamped wrongly by e is off by speed * e at that instant only. Over
// an interval the error is the difference of two of them. It shows in two ways. Innovations are
// larger than their noise explains, by 2 variance(e) * speed^2 when the errors of neighbours are
// independent. And consecutive innovations err in opposite directions, with a covariance of
// -variance(e) * speed^2, where that of noise and slip is zero or positive (autocovariance at lag
// one of a moving average of first order; Box and Jenkins, Time Series Analysis, section 3.3).
// Errors that alternate count up to four times in the second, those that change slowly hardly at
// all.
#pragma once

#include <algorithm>
#include <cmath>

namespace gw::dr_ekf {

struct StampError {
  double surplus = 0;  // m^2, half the sum of squares of innovations beyond their noise
  double opposed = 0;  // m^2, minus the sum of products of consecutive innovations
  double last = 0;     // m, the innovation before
  double speed2 = 0;   // m^2/s^2, sum of squares of the speed

  // Estimates are forgotten over this time: conditions of a computer change in minutes, and a mean
  // of a hundred products is good to a third.
  static constexpr double kMemory = 30;  // s
  // Before anything is known: the time error as a share of the period, with the weight of this many
  // samples at this speed. Drivers that stamp on arrival are good to a few percent of a period.
  static constexpr double kPriorShare = 0.05;
  static constexpr double kPriorWeight = 5 * 0.04;  // m^2/s^2: five samples at 0.2 m/s

  // Five times that: the estimate is more than a guess.
  static constexpr double kKnownWeight = 1;  // m^2/s^2
  // What is not known of the noise itself is no time error.
  static constexpr double kModelSlack = 1.5;

  // An innovation of one interval (wheels minus what measures the way besides them), the variance
  // it has without time errors, and the speed.
  void Add(double innovation, double variance, double speed, double dt) {
    const double forget = std::exp(-dt / kMemory);
    surplus = forget * surplus + 0.5 * (innovation * innovation - kModelSlack * variance);
    opposed = forget * opposed - innovation * last;
    last = innovation;
    speed2 = forget * speed2 + speed * speed;
  }

  bool known() const { return speed2 > kKnownWeight; }

  // s^2, the larger of the two: what a sum may be off. At most half a period: more would put
  // samples into the wrong order.
  double Variance(double period) const { return Bounded(std::max(opposed, surplus), period); }
  // s^2, what the size of the innovations says: what they may differ by without slip.
  double SizeVariance(double period) const { return Bounded(surplus, period); }

 private:
  double Bounded(double told, double period) const {
    const double prior = kPriorShare * kPriorShare * period * period;
    const double mean = (told + prior * kPriorWeight) / (speed2 + kPriorWeight);
    return std::clamp(mean, 0.0, 0.25 * period * period);
  }
};

}  // namespace gw::dr_ekf

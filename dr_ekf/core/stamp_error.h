// How wrong the stamps of the wheels' samples are: jitter, lateness, resampling.
//
// A sum of the wheels that is stamped wrongly by e is off by speed * e at that instant only. Over
// an interval the error is the difference of two of them: innovations are larger than their noise
// explains, by 2 variance(e) * speed^2 when the errors of neighbours are independent (by up to
// twice that when they alternate, as in odometry that was resampled). Slip and noise do so as well;
// slip is left out by whoever calls this, and what noise adds is bounded, since time errors are.
#pragma once

#include <algorithm>
#include <cmath>

namespace gw::dr_ekf {

struct StampError {
  double surplus = 0;  // m^2, half the sum of squares of innovations beyond their noise
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
    speed2 = forget * speed2 + speed * speed;
  }

  bool known() const { return speed2 > kKnownWeight; }

  // s^2; at most half a period: more would put samples into the wrong order.
  double Variance(double period) const {
    const double prior = kPriorShare * kPriorShare * period * period;
    const double mean = (surplus + prior * kPriorWeight) / (speed2 + kPriorWeight);
    return std::clamp(mean, 0.0, 0.25 * period * period);
  }
};

}  // namespace gw::dr_ekf

// How much noisier a sensor is on this robot than its calibration says: tyres that slide in every
// turn, an accelerometer that is shaken, filtered or not where it is said to be. Tracked as a
// quantile of the normalised squares of sums of innovations (Robbins and Monro, A stochastic
// approximation method, 1951): when the factor is right, one in ten of them lies above kQuantile
// (chi-square with one degree of freedom). Such sensors err seldom, but then by much: a high
// quantile sees that, a mean or a median does not.
#pragma once

#include <algorithm>
#include <cmath>

namespace gw::dr_ekf {

struct NoiseFactor {
  double log_variance = 0;

  static constexpr double kQuantile = 2.706;  // of chi-square, one degree of freedom, 90 %
  static constexpr double kShareAbove = 0.1;
  static constexpr double kGain = 3;
  static constexpr double kMost = 10000;  // a hundred times the sigma

  // normalised: square of a sum of innovations over its variance, factor included. passed: since
  // the one before, in s or rad; a factor that is too large by e is gone after 3.3 of them.
  void Add(double normalised, double passed) {
    const double above = normalised > kQuantile ? 1.0 : 0.0;
    log_variance += kGain * passed * (above - kShareAbove);
    log_variance = std::clamp(log_variance, 0.0, std::log(kMost));
  }
  double value() const { return std::exp(log_variance); }
};

}  // namespace gw::dr_ekf

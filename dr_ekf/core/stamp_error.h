// How wrong the stamps of the wheels' samples are: jitter, lateness, resampling.
//
// A sum of the wheels that is stamped wrongly by e is off by speed * e at that instant only. Over
// an interval the error is the difference of two of them, so that consecutive intervals err in
// opposite directions: the covariance of consecutive innovations is -variance(e) * speed^2, where
// that of noise and slip is zero or positive. The mean of the product tells the variance.
//
// Source: moving-average process of first order, autocovariance at lag one (Box and Jenkins, Time
// Series Analysis, section 3.3).
#pragma once

#include <algorithm>
#include <cmath>

namespace gw::dr_ekf {

struct StampError {
  // Speeds are those of the wheels' rims: that of the body, and of its turn at half the track.
  double product = 0;                 // m^2, minus the sum of products of consecutive innovations
  double speed2 = 0;                  // m^2/s^2, sum of the products of the speeds
  double last_way = 0, last_rim = 0;  // m, the innovations before; the next one needs them
  double last_speed = 0, last_rim_speed = 0;  // m/s
  bool has_last = false;

  // Estimates are forgotten over this time: conditions of a computer change in minutes, and a mean
  // of a hundred products is good to a third.
  static constexpr double kMemory = 30;  // s
  // Before anything is known: the time error as a share of the period, with the weight of this many
  // samples at this speed. Drivers that stamp on arrival are good to a few percent of a period.
  static constexpr double kPriorShare = 0.05;
  static constexpr double kPriorWeight = 5 * 0.04;  // m^2/s^2: five samples at 0.2 m/s

  // Innovations of one interval: wheels minus gyro or accelerometer, where those exist (else 0 with
  // a speed of 0).
  void Add(double way, double speed, double rim, double rim_speed, double dt) {
    const double forget = std::exp(-dt / kMemory);
    if (has_last) {
      product = forget * product - way * last_way - rim * last_rim;
      speed2 =
          forget * speed2 + std::abs(speed * last_speed) + std::abs(rim_speed * last_rim_speed);
    }
    last_way = way;
    last_rim = rim;
    last_speed = speed;
    last_rim_speed = rim_speed;
    has_last = true;
  }

  // After an interval that says nothing.
  void Break() { has_last = false; }

  // s^2; at most half a period: more would put samples into the wrong order.
  double Variance(double period) const {
    const double prior = kPriorShare * kPriorShare * period * period;
    const double mean = (product + prior * kPriorWeight) / (speed2 + kPriorWeight);
    return std::clamp(mean, 0.0, 0.25 * period * period);
  }
};

}  // namespace gw::dr_ekf

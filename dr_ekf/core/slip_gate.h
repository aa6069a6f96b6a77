// Tells slip from noise in one axis of the wheels' innovations (wheels minus gyro, or minus
// accelerometer).
//
// Innovations of a model that holds are white: the variance of a sum of them is the sum of their
// variances. Slip makes them all err to one side, and shows in the sum of the last half second long
// before it shows in one of them.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/core/time.h"

namespace gw::dr_ekf {

struct SlipGate {
  double sum = 0;       // of the innovations, forgotten over kMemory
  double variance = 0;  // of that sum, without slip
  bool rejecting = false;
  Utime rejecting_since;
  double speed_before = 0;  // m/s, of the robot when it began to reject

  static constexpr double kMemory = 0.5;  // s

  // Takes the innovation of an interval of dt that ends at utime, decides on `rejecting`, and
  // returns how far the innovation or the sum is past its limit, as a ratio of squares: above 1 the
  // innovation is not what the model expects. One that is alone in that is an outlier, not slip.
  // least: a sum below it is no slip, however small the noise is said to be.
  double Judge(double innovation, double innovation_variance, double gate_sigma, double least,
               Utime utime, double dt) {
    const double forget = std::exp(-dt / kMemory);
    sum = forget * sum + innovation;
    variance = forget * forget * variance + innovation_variance;
    const double limit = std::max(gate_sigma * std::sqrt(variance), least);
    const double excess_of_sum = sum * sum / (limit * limit);
    if (excess_of_sum > 1 && !rejecting) rejecting_since = utime;
    const bool over = rejecting && excess_of_sum <= 1;
    rejecting = excess_of_sum > 1;
    // What a slip has left in the sum says nothing of what comes after it.
    if (over) sum = 0;
    // Enough of the sum to refuse the next one too, not so much that it outlives the slip.
    sum = std::clamp(sum, -1.2 * limit, 1.2 * limit);
    return std::max(excess_of_sum,
                    innovation * innovation / (innovation_variance * gate_sigma * gate_sigma));
  }
};

}  // namespace gw::dr_ekf

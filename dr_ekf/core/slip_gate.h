// Tells slip from noise in one axis of the wheels' innovations (wheels minus gyro, or minus
// accelerometer).
//
// Innovations of a model that holds are white: the variance of a sum of them is the sum of their
// variances. Slip makes them all err to one side, and shows in the sum of the last half second long
// before it shows in one of them. Time errors of the wheels' samples do not add up in the sum: it
// is off by that of the newest sample and that of the first one, however many are between.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "common/core/time.h"

namespace gw::dr_ekf {

struct SlipGate {
  // One interval, that ends at utime.
  struct Interval {
    double innovation = 0;
    double variance = 0;  // of the innovation, without the parts below
    // Sigmas of parts that err to one side all the time, each with its sign: by a scale that is
    // wrong, with the motion; by a rate that is wrong, with time.
    Eigen::Vector2d coherent = Eigen::Vector2d::Zero();
    double sum_error = 0;  // variance of the error of one sum: time error, quantisation
    double least = 0;      // a sum below it is no slip, however small the noise is said to be
    Utime utime;
    double dt = 0;
  };
  enum class Verdict { kAgrees, kOutlier, kSlip };

  double memory = 0.5;  // s
  double sum = 0;       // of the innovations, forgotten over `memory`
  double variance = 0;  // of that sum, without slip
  Eigen::Vector2d coherent = Eigen::Vector2d::Zero();  // sigmas of the coherent parts of that sum
  double sum_error = 0;                                // largest of the newest
  double normalised = 0;                               // square of that sum over its whole variance
  bool rejecting = false;
  Utime rejecting_since = {};
  double speed_before = 0;  // m/s, of the robot when it began to reject
  bool counted = false;     // this slip speaks against who found it

  // excess: how far the innovation or the sum is past its limit, as a ratio of squares: above 1 the
  // innovation is not what the model expects. One that is alone in that is an outlier, not slip.
  Verdict Judge(const Interval& in, double gate_sigma, double* excess) {
    const double forget = std::exp(-in.dt / memory);
    sum = forget * sum + in.innovation;
    variance = forget * forget * variance + in.variance;
    coherent = forget * coherent + in.coherent;
    sum_error = std::max(forget * sum_error, in.sum_error);
    const double total = variance + coherent.squaredNorm() + 2 * sum_error;
    normalised = sum * sum / total;
    const double limit = std::max(gate_sigma * std::sqrt(total), in.least);
    const double excess_of_sum = sum * sum / (limit * limit);
    if (excess_of_sum > 1 && !rejecting) rejecting_since = in.utime;
    const bool over = rejecting && excess_of_sum <= 1;
    rejecting = excess_of_sum > 1;
    // What a slip has left in the sum says nothing of what comes after it.
    if (over) sum = 0;
    // Enough of the sum to refuse the next one too, not so much that it outlives the slip.
    sum = std::clamp(sum, -1.2 * limit, 1.2 * limit);
    const double own = in.variance + in.coherent.squaredNorm() + 2 * in.sum_error;
    const double excess_of_one = in.innovation * in.innovation / (own * gate_sigma * gate_sigma);
    *excess = std::max(excess_of_sum, excess_of_one);
    if (rejecting) return Verdict::kSlip;
    return *excess > 1 ? Verdict::kOutlier : Verdict::kAgrees;
  }
};

}  // namespace gw::dr_ekf

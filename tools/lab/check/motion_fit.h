// Two sensors that tell the same motion, against each other: scale, sign, delay.
#pragma once

#include <optional>
#include <vector>

#include "common/core/time.h"

namespace gw::check {

// A sensor's sum of a motion (turn in rad, way in m) since its begin, between its samples on a
// straight line.
class MotionSum {
 public:
  void Add(Utime utime, double sum);
  bool empty() const { return times_.empty(); }
  // Empty outside of the samples, and within gaps of more than 0.3 s.
  std::optional<double> At(Utime utime) const;

 private:
  std::vector<Utime> times_;
  std::vector<double> sums_;
};

struct MotionStep {
  Utime begin, end;
  double motion = 0;  // of the reference
};

struct MotionFit {
  double scale = 0;        // other over reference
  double sigma_scale = 0;  // standard deviation
  double delay_s = 0;      // the other's stamps are later by this
  double sigma_delay_s = 0;
  double correlation = 0;  // at that delay, -1 to 1
  double moved = 0;        // sum of the sizes of the motion, of the one that tells more of it
};

// Least squares of  other = scale * reference + bias * time  over the steps, at the delay within
// +- 0.5 s (of `around`) where the rest is smallest. Empty when fewer than 20 steps are covered, or
// they hold less motion than `least`.
std::optional<MotionFit> FitMotion(const std::vector<MotionStep>& reference, const MotionSum& other,
                                   DurationUs around, double least);

}  // namespace gw::check

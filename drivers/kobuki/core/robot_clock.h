// Robot time to host time: when was it on this computer's clock that the base measured?
//
// A frame arrives a constant delay plus some waiting after its measurement (USB latency timer,
// scheduling, bursts). The waiting is taken out by a lower envelope over the last 30 s. The
// constant part cannot be seen from arrivals and stays in, unless it is known and configured.
#pragma once

#include <algorithm>
#include <optional>

#include "common/core/time.h"
#include "drivers/kobuki/core/lower_envelope.h"

namespace gw::kobuki {

class RobotClock {
 public:
  // One measurement at `robot_us` of the robot's unwrapped clock, arrived at `arrival`.
  // Precondition: robot_us does not decrease between resets.
  void Add(int64_t robot_us, Utime arrival);

  // Whether enough arrivals were seen for ToHost to hold within a few milliseconds.
  bool ready() const { return envelope_.span() >= kWarmUpUs; }
  // Time of arrival of a frame of this robot time that did not have to wait. Precondition: Add was
  // called since the last reset.
  Utime ToHost(int64_t robot_us) const;

  void Reset();

  // Of the newest arrival: how much later than without waiting.
  DurationUs waited() const { return waited_; }
  int64_t steps() const { return steps_; }

  static constexpr int64_t kWarmUpUs = 500'000;
  // Quartz clocks differ by less than 100 ppm each.
  static constexpr double kMaxDrift = 2e-4;
  // Arrivals that are later than expected by more than this for kStepAfterUs on end mean that one
  // of the clocks was stepped.
  static constexpr int64_t kStepUs = 300'000;
  static constexpr int64_t kStepAfterUs = 1'500'000;

 private:
  LowerEnvelope envelope_{{.bin = 250'000, .num_bins = 120, .max_slope = kMaxDrift}};
  DurationUs waited_;
  std::optional<Utime> late_since_;
  int64_t steps_ = 0;
};

}  // namespace gw::kobuki

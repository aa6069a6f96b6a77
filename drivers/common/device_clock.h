// Maps device time to host time: tells when, on this computer's clock, the device measured.
//
// What a device sends arrives a constant delay plus some waiting after its measurement (USB latency
// timer, scheduling, bursts). The waiting is taken out by a lower envelope over the last 30 s. The
// constant part cannot be seen from arrivals and stays in, unless it is known and configured.
#pragma once

#include <algorithm>
#include <optional>

#include "common/core/time.h"
#include "drivers/common/lower_envelope.h"

namespace gw {

class DeviceClock {
 public:
  // Takes one measurement that was made at `device_us` of the device's unwrapped clock and arrived
  // at `arrival`. Precondition: device_us does not decrease between resets.
  void Add(int64_t device_us, Utime arrival);

  // True when enough arrivals were seen for ToHost() to hold within a few milliseconds.
  bool ready() const { return envelope_.span() >= kWarmUpUs; }
  // The time at which something measured at this device time arrives if it does not have to wait.
  // Precondition: Add() was called since the last reset.
  Utime ToHost(int64_t device_us) const;

  void Reset();

  // How much later the newest measurement arrived than it would have without waiting.
  DurationUs waited() const { return waited_; }
  int64_t steps() const { return steps_; }

  static constexpr int64_t kWarmUpUs = 500'000;
  // The largest drift of the two clocks: quartz clocks are off by less than 100 ppm each.
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

}  // namespace gw

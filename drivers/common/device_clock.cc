#include "drivers/common/device_clock.h"

#include <cmath>

namespace gw {

void DeviceClock::Add(int64_t device_us, Utime arrival) {
  if (!envelope_.empty()) {
    waited_ = arrival - ToHost(device_us);
    if (waited_.us < kStepUs) {
      late_since_.reset();
    } else if (!late_since_) {
      late_since_ = arrival;
    } else if ((arrival - *late_since_).us > kStepAfterUs) {
      Reset();
      ++steps_;
    }
    // An arrival so far before all others is not explained by drift, only by a clock that was
    // stepped back.
    if (waited_.us < -kStepUs) {
      Reset();
      ++steps_;
    }
  }
  envelope_.Add(device_us, arrival.us - device_us);
}

Utime DeviceClock::ToHost(int64_t device_us) const {
  return {device_us + std::llround(envelope_.At(device_us))};
}

void DeviceClock::Reset() {
  envelope_.Clear();
  waited_ = {};
  late_since_.reset();
}

}  // namespace gw

// What time it is where the robot is: the newest stamp of a sensor, carried on by the clock since
// it came. With a robot that is now, a little late; with a simulator that falls behind the clock,
// or a replayed log, it is the time of that world, so that the age of a pose means the same.
#pragma once

#include <algorithm>
#include <optional>

#include "common/core/time.h"

namespace gw::navigate {

class BusTime {
 public:
  // clock: when the sample with this stamp arrived.
  void Observe(Utime stamp, Utime clock) {
    if (newest_ && stamp <= *newest_) return;
    newest_ = stamp;
    arrived_ = clock;
  }

  // Never goes back. Empty before the first sample.
  std::optional<Utime> At(Utime clock) {
    if (!newest_) return std::nullopt;
    last_ = std::max(last_, *newest_ + (clock - arrived_));
    return last_;
  }

 private:
  std::optional<Utime> newest_;
  Utime arrived_;
  Utime last_;
};

}  // namespace gw::navigate

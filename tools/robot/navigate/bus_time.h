// What time it is where the robot is: the newest stamp of a sensor; when none comes for longer than
// kGrace, carried on by the clock. With a robot that is now, a little late; with a simulator that
// falls behind the clock it is the time of that world, so that the age of a pose means the same.
// The grace covers sensors that arrive in bursts, as from a simulator that renders in between.
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
    last_ = std::max(last_, *newest_ + std::max(DurationUs{0}, clock - arrived_ - kGrace));
    return last_;
  }

  static constexpr DurationUs kGrace = Milliseconds(100);

 private:
  std::optional<Utime> newest_;
  Utime arrived_;
  Utime last_;
};

}  // namespace gw::navigate

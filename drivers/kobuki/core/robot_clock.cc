#include "drivers/kobuki/core/robot_clock.h"

#include <cmath>

namespace gw::kobuki {

void RobotClock::Add(int64_t robot_us, Utime arrival) {
  if (!envelope_.empty()) {
    waited_ = arrival - ToHost(robot_us);
    if (waited_.us < kStepUs) {
      late_since_.reset();
    } else if (!late_since_) {
      late_since_ = arrival;
    } else if ((arrival - *late_since_).us > kStepAfterUs) {
      Reset();
      ++steps_;
    }
    // So far before all others: no drift explains it, only a clock that was stepped back.
    if (waited_.us < -kStepUs) {
      Reset();
      ++steps_;
    }
  }
  envelope_.Add(robot_us, arrival.us - robot_us);
}

Utime RobotClock::ToHost(int64_t robot_us) const {
  return {robot_us + std::llround(envelope_.At(robot_us))};
}

void RobotClock::Reset() {
  envelope_.Clear();
  waited_ = {};
  late_since_.reset();
}

}  // namespace gw::kobuki

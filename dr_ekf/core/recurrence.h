// Tells a fault of a stream from a single bad sample: what happens ten times within two seconds of
// the stamps is no accident of a network or a bus.
#pragma once

#include <cstddef>
#include <deque>

#include "common/core/time.h"

namespace gw::dr_ekf {

class Recurrence {
 public:
  static constexpr size_t kMany = 10;
  static constexpr DurationUs kWithin = Milliseconds(2000);

  // It happened once more. True when it happens again and again. A stamp that goes back begins a
  // new count.
  bool Add(Utime utime) {
    if (!times_.empty() && utime < times_.back()) times_.clear();
    times_.push_back(utime);
    while (utime - times_.front() > kWithin || times_.size() > kMany) times_.pop_front();
    return times_.size() == kMany;
  }

 private:
  std::deque<Utime> times_;  // the newest, at most kMany
};

}  // namespace gw::dr_ekf

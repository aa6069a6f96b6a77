// Lets through at most one thing per interval, by the times it is told.
#pragma once

#include <optional>

#include "common/core/time.h"

namespace gw::foxglove {

class RateLimit {
 public:
  explicit RateLimit(DurationUs interval) : interval_(interval) {}

  // True, and counted, when the interval is over. A time that goes back begins anew.
  bool Pass(Utime now) {
    if (last_ && now >= *last_ && now - *last_ < interval_) return false;
    last_ = now;
    return true;
  }
  void set_interval(DurationUs interval) { interval_ = interval; }

 private:
  DurationUs interval_;
  std::optional<Utime> last_;
};

}  // namespace gw::foxglove

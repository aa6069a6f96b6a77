// Checks whether the time stamps of a sensor belong to this computer's clock. Every sample arrives
// a little after it was measured; the least of these delays tells a wrong clock from a busy
// computer.
#pragma once

#include <algorithm>
#include <optional>

#include "common/core/time.h"

namespace gw::camera {

class LagCheck {
 public:
  // Takes a sample that was measured at `utime` and read at `now`.
  void Add(Utime utime, Utime now) {
    if (!begin_) begin_ = now;
    newest_ = std::min(newest_.value_or(now - utime), now - utime);
    if (now - *begin_ < kWindow) return;
    least_ = newest_;
    newest_.reset();
    begin_ = now;
  }
  // The least delay of the last full window; empty before the first one ended.
  std::optional<DurationUs> least() const { return least_; }
  // True when samples come from the future, or are too old for any buffering: the clocks differ.
  bool skewed() const { return least_ && (*least_ < -kMaxAhead || *least_ > kMaxLag); }

  static constexpr DurationUs kWindow = Milliseconds(1000);
  static constexpr DurationUs kMaxAhead = Milliseconds(2);
  static constexpr DurationUs kMaxLag = Milliseconds(100);

 private:
  std::optional<Utime> begin_;
  std::optional<DurationUs> newest_;
  std::optional<DurationUs> least_;
};

}  // namespace gw::camera

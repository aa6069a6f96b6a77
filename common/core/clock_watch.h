// Tells a sample that comes late from a clock that was set back. Late samples are few, or older
// than each other; after a clock was set back, all that follow are behind the newest time, and in
// order among themselves.
#pragma once

#include <optional>

#include "common/core/time.h"

namespace gw {

class ClockWatch {
 public:
  enum class Verdict {
    kInOrder,  // newer than all before
    kLate,     // not newer; to be refused
    kSetBack,  // the clock was set back: this is the first sample of the new time
  };
  // So many samples in order show that the clock was set back; what is reordered on its way is
  // fewer.
  static constexpr int kConfirming = 3;

  Verdict Judge(Utime utime) {
    if (!newest_ || utime > *newest_) {
      newest_ = utime;
      late_in_order_ = 0;
      return Verdict::kInOrder;
    }
    late_in_order_ = late_in_order_ > 0 && utime > newest_late_ ? late_in_order_ + 1 : 1;
    newest_late_ = utime;
    if (late_in_order_ < kConfirming) return Verdict::kLate;
    newest_ = utime;
    late_in_order_ = 0;
    return Verdict::kSetBack;
  }

 private:
  std::optional<Utime> newest_;
  Utime newest_late_;
  int late_in_order_ = 0;
};

}  // namespace gw

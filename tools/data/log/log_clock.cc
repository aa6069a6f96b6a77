#include "tools/data/log/log_clock.h"

#include <algorithm>

#include "tools/data/files/format.h"

namespace gw::tools {

std::string Describe(const TimeStep& step) {
  const bool back = step.to < step.from;
  const DurationUs size = back ? step.from - step.to : step.by();
  return Format("time %s by %.3f s at event %lld (from %.6f to %.6f)",
                back ? "goes back" : "jumps ahead", size.seconds(),
                static_cast<long long>(step.index), step.from.seconds(), step.to.seconds());
}

DurationUs LogClock::Add(Utime received) {
  const int64_t index = events_++;
  if (index == 0) {
    piece_begin_ = newest_ = received;
    return {0};
  }
  const DurationUs step = received - newest_;
  const bool goes_back = step.us < -kTimeGoesBack.us;
  if (goes_back || step > kTimeJumpsAhead) steps_.push_back({index, newest_, received});
  if (goes_back) {
    piece_begin_ = newest_ = received;
    piece_start_ = length_;
  }
  newest_ = std::max(newest_, received);
  const DurationUs since_begin = std::max(piece_start_ + (received - piece_begin_), DurationUs{0});
  length_ = std::max(length_, since_begin);
  return since_begin;
}

}  // namespace gw::tools

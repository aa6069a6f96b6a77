// The time of a log, also of one in which it goes back: logs that were joined (cat a.lcm b.lcm), or
// recorded while the clock was set.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/core/time.h"

namespace gw::tools {

// Events are received in the order in which they stand in the log, so their time may go back only
// when the clock was set or another log begins. Logs merged by a tool may be in disorder by some
// milliseconds; a second is far beyond that and below any pause between two recordings.
inline constexpr DurationUs kTimeGoesBack = Milliseconds(1000);
// HEALTH comes every second, so that a robot is never silent for so long.
inline constexpr DurationUs kTimeJumpsAhead = Milliseconds(10000);

// Where the receive time goes back or jumps ahead.
struct TimeStep {
  int64_t index = 0;  // of the event with the new time, counted from 0 in the file
  Utime from;         // newest before
  Utime to;

  DurationUs by() const { return to - from; }
};

// "time goes back by 10.000 s at event 812 (from 1700000007.450 to 1699999997.450)".
std::string Describe(const TimeStep& step);

class LogClock {
 public:
  // Takes the next event; returns the time since the begin of the log. Where time goes back, that
  // time goes on from where it was: the pieces of a joined log follow each other. Never negative.
  DurationUs Add(Utime received);

  const std::vector<TimeStep>& steps() const { return steps_; }
  // Length of the log, all pieces one after the other.
  DurationUs length() const { return length_; }

 private:
  int64_t events_ = 0;
  Utime piece_begin_;       // first event since time went back
  DurationUs piece_start_;  // its time since the begin of the log
  Utime newest_;            // of the piece
  DurationUs length_;
  std::vector<TimeStep> steps_;
};

}  // namespace gw::tools

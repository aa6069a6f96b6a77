// Wheels of a driver that takes a base at a slower rate of its own: it sums the base's intervals
// and stamps the sums as if they were equally long.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "common/contract/samples.h"

namespace gw::fault {

class WheelResampler {
 public:
  // period: by the stamps; short_of_even: every other sum ends so much before its stamp.
  WheelResampler(DurationUs period, DurationUs short_of_even)
      : period_(period), short_of_even_(short_of_even) {}

  // The sums whose stamp has come with this sample. What the base did between its own samples is
  // interpolated, so that any input rate will do. seq counts the sums, from the first sample's.
  std::vector<WheelSample> Push(const WheelSample& sample);

 private:
  // What the wheels have counted at an instant.
  struct Count {
    Utime utime;
    SE3 T_OB;
    double left = 0, right = 0, heading_rad = 0;  // since the begin
  };
  Count Between(const WheelSample& sample, Utime utime) const;
  WheelSample Sum(const WheelSample& sample, const Count& end, Utime stamp) const;

  DurationUs period_, short_of_even_;
  std::optional<Utime> begin_;
  int64_t first_seq_ = 0;
  int64_t sums_ = 0;              // made
  std::deque<WheelSample> made_;  // wait for their stamp
  Count last_;                    // at the end of the last sample
  Count given_;                   // at the end of the last sum
  WheelSample first_, previous_;  // where counters and heading began, and where they are
};

}  // namespace gw::fault

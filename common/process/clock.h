// The robot's clock: microseconds since the epoch that no time server can bend.
//
// It is the monotonic clock plus an offset that the first process after boot takes from the
// system's clock and leaves in a file for all others. Only drivers and process shells may use it.
#pragma once

#include <string>

#include "common/core/time.h"

namespace gw::process {

class Clock {
 public:
  // offset_file: read, or written when it is not there. Where neither works (a developer's machine
  // without /run/gw), the offset is taken now and belongs to this process alone.
  explicit Clock(const std::string& offset_file = "/run/gw/epoch_offset_us");

  Utime Now() const;
  // This clock minus CLOCK_MONOTONIC, for what the kernel stamps.
  DurationUs monotonic_offset() const { return {offset_us_}; }
  bool shared() const { return shared_; }  // all processes have the same offset

 private:
  int64_t offset_us_ = 0;
  bool shared_ = false;
};

}  // namespace gw::process

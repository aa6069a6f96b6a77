// Unwraps the robot's 16-bit clock and decides whether a frame continues the one before, so that
// neither a reboot of the base, nor a gap, nor a corrupt frame with a right checksum ever becomes
// motion.
#pragma once

#include <cstdint>
#include <optional>

#include "common/core/time.h"

namespace gw::kobuki {

struct FrameStamp {
  uint16_t timestamp_ms = 0;  // the robot's clock
  uint16_t left_ticks = 0;
  uint16_t right_ticks = 0;
  Utime arrival;
};

class FrameSequence {
 public:
  enum class Verdict {
    kContinues,  // differences to the last frame that continued or restarted are motion
    kDuplicate,  // the same robot time again: nothing new
    kHeld,       // does not fit; the next frame will tell whether this one was corrupt
    kRestarts,   // a new beginning: differences to earlier frames mean nothing
  };
  struct Judgement {
    Verdict verdict = Verdict::kHeld;
    int64_t robot_us = 0;   // unwrapped time of kContinues and kRestarts, which continues over gaps
    bool rebooted = false;  // of kRestarts: the robot's clock began anew, and so does robot_us
  };

  Judgement Judge(const FrameStamp& stamp);

  int64_t corrupt() const { return corrupt_; }    // held frames that the next frame disproved
  int64_t restarts() const { return restarts_; }  // restarts after the first beginning
  int64_t reboots() const { return reboots_; }

  // The largest motion that is believed: 0.7 m/s is 164 ticks in 20 ms, and half as much again is
  // no motion of this base.
  static constexpr double kMaxTicksPerMs = 12.5;
  // The longest gap that is bridged: a longer one could hide half a turn of the 16-bit encoders (4
  // s at 0.7 m/s).
  static constexpr int64_t kMaxGapMs = 3000;
  // How far host and robot may disagree on a time span, because deliveries wait.
  static constexpr int64_t kMaxEarlyMs = 1500;  // when the frame before had waited
  static constexpr int64_t kMaxLateMs = 5000;   // when this frame has waited

 private:
  static bool Follows(const FrameStamp& before, const FrameStamp& after);

  std::optional<FrameStamp> last_;
  std::optional<FrameStamp> suspect_;
  int64_t robot_us_ = 0;
  int64_t corrupt_ = 0;
  int64_t restarts_ = 0;
  int64_t reboots_ = 0;
};

}  // namespace gw::kobuki

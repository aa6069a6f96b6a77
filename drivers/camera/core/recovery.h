// What to do when a camera that is there does not deliver: restart the stream, then reset it on the
// USB, then give up. Events and times in, decisions out.
#pragma once

#include <cstdint>
#include <optional>

#include "common/core/time.h"

namespace gw::camera {

enum class Remedy { kNone, kRestartStream, kResetUsb, kGiveUp };

class Recovery {
 public:
  void Started(Utime now);  // the stream was started, or the start failed
  void Frame(Utime now);    // a good frame came
  void Failed();            // the stream broke: an error of the device, or the start failed
  // The camera is gone. Absence is no failure of the stream: nothing is done, and nothing counted,
  // until it is started again.
  void Gone();

  // To be called often; each remedy is given once and counts as tried.
  Remedy Next(Utime now);

  int64_t restarts() const { return restarts_; }
  int64_t resets() const { return resets_; }

  static constexpr DurationUs kFirstFrame = Milliseconds(3000);  // after a start
  static constexpr DurationUs kSilent = Milliseconds(1000);      // between frames
  static constexpr DurationUs kPause = Milliseconds(500);  // before a failed start is repeated
  static constexpr int kRestartsPerReset = 3;
  static constexpr int kResets = 2;
  // So long without a failure makes it well: the ladder begins at its foot again.
  static constexpr DurationUs kWell = Milliseconds(3000);
  // A longer time between two calls of Next means that we slept, not the camera: it is no silence.
  static constexpr DurationUs kSlept = Milliseconds(300);

 private:
  std::optional<Utime> started_;
  std::optional<Utime> last_frame_;
  std::optional<Utime> well_since_;
  std::optional<Utime> last_next_;
  bool failed_ = false;
  int restarts_tried_ = 0;  // since the last reset
  int resets_tried_ = 0;
  int64_t restarts_ = 0;
  int64_t resets_ = 0;
};

}  // namespace gw::camera

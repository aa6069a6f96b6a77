// Decides what to do when a camera that is there does not deliver: restart the stream, then reset
// the camera on the USB, then give up. Events and times go in, decisions come out.
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

  // The remedy that is due, if any; to be called often. Each remedy is given once and counts as
  // tried.
  Remedy Next(Utime now);

  int64_t restarts() const { return restarts_; }
  int64_t resets() const { return resets_; }

  // The longest wait for the first frame after a start.
  static constexpr DurationUs kFirstFrame = Milliseconds(3000);
  static constexpr DurationUs kSilent = Milliseconds(1000);  // the longest pause between frames
  // The pause before a failed start is repeated.
  static constexpr DurationUs kPause = Milliseconds(500);
  static constexpr int kRestartsPerReset = 3;
  static constexpr int kResets = 2;
  // A stream without a failure for this long is well again: the next failure begins with the
  // mildest remedy.
  static constexpr DurationUs kWell = Milliseconds(3000);
  // A longer time between two calls of Next() means that this program slept and not the camera, so
  // that it is no silence of the camera.
  static constexpr DurationUs kSlept = Milliseconds(300);

 private:
  std::optional<Utime> started_;
  std::optional<Utime> last_frame_;
  std::optional<Utime> well_since_;
  std::optional<Utime> last_next_;
  bool failed_ = false;
  int restarts_tried_ = 0;  // restarts of the stream since the last reset
  int resets_tried_ = 0;
  int64_t restarts_ = 0;
  int64_t resets_ = 0;
};

}  // namespace gw::camera

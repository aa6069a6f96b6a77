#include "drivers/camera/core/recovery.h"

namespace gw::camera {

void Recovery::Started(Utime now) {
  started_ = now;
  last_frame_.reset();
  well_since_.reset();
  failed_ = false;
}

void Recovery::Frame(Utime now) {
  if (!well_since_) well_since_ = now;
  last_frame_ = now;
  if (now - *well_since_ > kWell) restarts_tried_ = resets_tried_ = 0;
}

void Recovery::Failed() {
  failed_ = true;
}

void Recovery::Gone() {
  started_.reset();
  failed_ = false;
}

Remedy Recovery::Next(Utime now) {
  const Utime last = last_next_.value_or(now);
  last_next_ = now;
  const DurationUs pause = now - last;
  if (pause > kSlept) {
    for (std::optional<Utime>* const event : {&started_, &last_frame_}) {
      // Events from before the sleep count as if they came after it.
      if (*event && **event <= last) **event = **event + pause;
    }
  }
  if (!started_) return Remedy::kNone;
  const bool silent = last_frame_ ? now - *last_frame_ > kSilent : now - *started_ > kFirstFrame;
  if (!silent && !(failed_ && now - *started_ > kPause)) return Remedy::kNone;
  started_.reset();
  if (restarts_tried_ < kRestartsPerReset) {
    ++restarts_tried_;
    ++restarts_;
    return Remedy::kRestartStream;
  }
  if (resets_tried_ == kResets) return Remedy::kGiveUp;
  restarts_tried_ = 0;
  ++resets_tried_;
  ++resets_;
  return Remedy::kResetUsb;
}

}  // namespace gw::camera

#include "drivers/camera/core/frame_clock.h"

namespace gw::camera {

std::optional<int64_t> FrameClock::DeviceTime(const RawFrame& frame) {
  const auto frames_since = static_cast<int32_t>(frame.sequence - sequence_);
  if (!frame.metadata || !frame.metadata->pts_us) {
    if (period_us_ == 0 || frames_since < 1 || frames_since > kMaxExtrapolated) return std::nullopt;
    return device_us_ + frames_since * period_us_;
  }
  const uint32_t pts = *frame.metadata->pts_us;
  const auto step = static_cast<int32_t>(pts - last_pts_us_);
  if (has_device_time_ && (step <= 0 || frames_since < 1)) {  // the camera was reset
    Restart();
    ++restarts_;
  }
  if (has_device_time_) {
    device_us_ += step;
    period_us_ = step / frames_since;
  } else {
    device_us_ = pts;
  }
  has_device_time_ = true;
  last_pts_us_ = pts;
  sequence_ = frame.sequence;
  clock_.Add(device_us_, frame.arrival);
  return device_us_;
}

std::optional<FrameClock::Stamp> FrameClock::Add(const RawFrame& frame, uint32_t set_exposure_us) {
  const auto device_us = DeviceTime(frame);
  uint32_t exposure_us = set_exposure_us;
  if (frame.metadata && frame.metadata->exposure_us) exposure_us = *frame.metadata->exposure_us;
  uint32_t to_mid_us = exposure_us / 2;
  if (frame.metadata && frame.metadata->to_mid_exposure_us) {
    to_mid_us = *frame.metadata->to_mid_exposure_us;
  }
  Utime stamped = frame.arrival;
  if (has_device_time_) {
    if (!device_us || !clock_.ready()) return std::nullopt;
    stamped = clock_.ToHost(*device_us);
  }
  const Utime mid_exposure = stamped - DurationUs{to_mid_us} - transport_delay_;
  if (last_ && mid_exposure <= *last_) return std::nullopt;
  last_ = mid_exposure;
  return Stamp{mid_exposure, static_cast<int32_t>(exposure_us)};
}

void FrameClock::Restart() {
  clock_.Reset();
  has_device_time_ = false;
  period_us_ = 0;
}

}  // namespace gw::camera

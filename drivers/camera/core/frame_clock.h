// When, on the host's clock, was the middle of the exposure of a frame?
//
// With metadata: the camera's 32-bit microsecond clock, unwrapped, mapped by the lower envelope of
// the arrivals (drivers/common/device_clock.h). The camera stamps the end of what it measures; the
// middle of the exposure is `to_mid_exposure_us` before, or half the exposure. Without metadata:
// the arrival less half the exposure, with all the jitter of arrivals.
//
// In both cases a constant delay from the camera's stamp to the arrival stays in unless it is
// configured.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/camera/core/raw_frame.h"
#include "drivers/common/device_clock.h"

namespace gw::camera {

class FrameClock {
 public:
  struct Stamp {
    Utime mid_exposure;
    int32_t exposure_us = 0;  // 0: unknown
  };

  explicit FrameClock(DurationUs transport_delay) : transport_delay_(transport_delay) {}

  // set_exposure_us: what the camera was told, used when its metadata do not say; 0: unknown.
  // Empty: the time is not known yet or any more, or would not be after that of the frame before.
  std::optional<Stamp> Add(const RawFrame& frame, uint32_t set_exposure_us);

  // The stream, and perhaps the camera's clock, begins anew.
  void Restart();

  const DeviceClock& device_clock() const { return clock_; }
  int64_t restarts() const { return restarts_; }  // of the camera's clock, seen in its stamps

 private:
  // Unwrapped device time of the frame; from the one before when the frame has none of its own.
  std::optional<int64_t> DeviceTime(const RawFrame& frame);

  // A frame without metadata counts on from the last with, at most over this many frames.
  static constexpr int64_t kMaxExtrapolated = 30;

  DurationUs transport_delay_;
  DeviceClock clock_;
  bool has_device_time_ = false;
  uint32_t last_pts_us_ = 0;
  int64_t device_us_ = 0;  // of the last frame with metadata
  uint32_t sequence_ = 0;  // of the same frame
  int64_t period_us_ = 0;  // between the last two with metadata, per frame
  std::optional<Utime> last_;
  int64_t restarts_ = 0;
};

}  // namespace gw::camera

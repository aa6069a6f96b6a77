// Tells when, on the host's clock, the middle of the exposure of a frame was.
//
// With metadata, the camera's 32-bit microsecond clock is unwrapped and mapped to the host's by the
// lower envelope of the arrivals (drivers/common/device_clock.h). The camera stamps the end of what
// it measures; the middle of the exposure lies `to_mid_exposure_us` before that, or half the
// exposure where the metadata do not say. Without metadata the time is the arrival less half the
// exposure, with all the jitter of arrivals.
//
// In both cases a constant delay from the camera's stamp to the arrival stays in, unless it is
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
    int32_t exposure_us = 0;  // 0 when the camera does not tell it
  };

  explicit FrameClock(DurationUs transport_delay) : transport_delay_(transport_delay) {}

  // `set_exposure_us` is the exposure that the camera was told; it is used when the metadata do not
  // say, and 0 means unknown. The result is empty while the time is not known, and when it would
  // not be after that of the frame before.
  std::optional<Stamp> Add(const RawFrame& frame, uint32_t set_exposure_us);

  // To be called when the stream, and perhaps the camera's clock with it, begins anew.
  void Restart();

  const DeviceClock& device_clock() const { return clock_; }
  // Restarts of the camera's clock, as seen in its stamps.
  int64_t restarts() const { return restarts_; }

 private:
  // The unwrapped device time of the frame; a frame without a time of its own counts on from the
  // one before.
  std::optional<int64_t> DeviceTime(const RawFrame& frame);

  // Over at most this many frames a frame without metadata counts on from the last one with.
  static constexpr int64_t kMaxExtrapolated = 30;

  DurationUs transport_delay_;
  DeviceClock clock_;
  bool has_device_time_ = false;
  uint32_t last_pts_us_ = 0;
  int64_t device_us_ = 0;  // device time of the last frame with metadata
  uint32_t sequence_ = 0;  // sequence number of the same frame
  int64_t period_us_ = 0;  // time per frame between the last two frames with metadata
  std::optional<Utime> last_;
  int64_t restarts_ = 0;
};

}  // namespace gw::camera

// Finds the depth image of the same exposure as a grey image. A D4xx camera makes both from one
// pair of exposures: their device times are equal. Without device times, arrivals decide.
#pragma once

#include <deque>
#include <optional>

#include "drivers/camera/core/raw_frame.h"

namespace gw::camera {

struct ImageAndDepth {
  RawFrame image, depth;
};

class DepthPairer {
 public:
  // `interval` is the time between two frames; two times that differ by less than half of it belong
  // to one exposure.
  explicit DepthPairer(DurationUs interval) : interval_(interval) {}

  // Frames of each stream must come in order. Each call gives a pair when the second half of it
  // came; a half whose partner cannot come any more is dropped.
  std::optional<ImageAndDepth> AddImage(RawFrame image);
  std::optional<ImageAndDepth> AddDepth(RawFrame depth);

  int64_t unpaired() const { return unpaired_; }

 private:
  // The difference of the two streams' times: how much later the image is than the depth image.
  int64_t ImageMinusDepthUs() const;
  std::optional<ImageAndDepth> Match();

  static constexpr size_t kMaxWaiting = 4;

  DurationUs interval_;
  std::deque<RawFrame> images_, depths_;
  int64_t unpaired_ = 0;
};

}  // namespace gw::camera

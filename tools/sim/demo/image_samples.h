// Keeps some of a run's camera images, evenly over its time, for the report.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "common/core/result.h"
#include "common/process/bus.h"

namespace gw::demo {

class ImageSamples {
 public:
  // The bus must live as long as the samples.
  static Result<Done> Attach(process::Bus& bus, ImageSamples& samples);

  struct Sample {
    Utime utime;
    cv::Mat left;  // 8-bit grey
  };
  // By time; up to kMost, at least kLeastSpacing apart.
  const std::vector<Sample>& samples() const { return samples_; }

  static constexpr size_t kMost = 240;
  static constexpr DurationUs kLeastSpacing = Milliseconds(500);

 private:
  void Take(std::span<const uint8_t> message);

  DurationUs spacing_ = kLeastSpacing;
  std::vector<Sample> samples_;
};

}  // namespace gw::demo

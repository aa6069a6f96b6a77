#include "tools/sim/demo/image_samples.h"

#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::demo {

Result<Done> ImageSamples::Attach(process::Bus& bus, ImageSamples& samples) {
  return bus.Subscribe(wire::kCamera,
                       [&samples](std::span<const uint8_t> bytes, Utime) { samples.Take(bytes); });
}

void ImageSamples::Take(std::span<const uint8_t> message) {
  const auto header = wire::ReadHeader(message);
  if (!header) return;
  if (!samples_.empty() && header->utime - samples_.back().utime < spacing_) return;
  const auto camera = wire::Decode<wire::DecodedCamera>(message);
  if (!camera || camera->frame.left.format != PixelFormat::kGray8) return;
  const ImageView& view = camera->frame.left;
  const cv::Mat left(view.height, view.width, CV_8U, const_cast<uint8_t*>(view.data),
                     static_cast<size_t>(view.stride));
  if (samples_.size() == kMost) {  // every second one from here on, and of those that are there
    for (size_t i = 0; 2 * i < kMost; ++i) samples_[i] = samples_[2 * i];
    samples_.resize(kMost / 2);
    spacing_ = spacing_ + spacing_;
  }
  samples_.push_back({header->utime, left.clone()});
}

}  // namespace gw::demo

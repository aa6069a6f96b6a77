#include "drivers/camera/core/depth_pairer.h"

#include <cstdlib>

namespace gw::camera {

int64_t DepthPairer::ImageMinusDepthUs() const {
  const RawFrame& image = images_.front();
  const RawFrame& depth = depths_.front();
  if (image.metadata && depth.metadata && image.metadata->pts_us && depth.metadata->pts_us) {
    return static_cast<int32_t>(*image.metadata->pts_us - *depth.metadata->pts_us);
  }
  return (image.arrival - depth.arrival).us;
}

std::optional<ImageAndDepth> DepthPairer::Match() {
  while (!images_.empty() && !depths_.empty()) {
    const int64_t difference = ImageMinusDepthUs();
    if (2 * std::abs(difference) < interval_.us) {
      ImageAndDepth pair{std::move(images_.front()), std::move(depths_.front())};
      images_.pop_front();
      depths_.pop_front();
      return pair;
    }
    (difference < 0 ? images_ : depths_).pop_front();
    ++unpaired_;
  }
  return std::nullopt;
}

std::optional<ImageAndDepth> DepthPairer::AddImage(RawFrame image) {
  images_.push_back(std::move(image));
  if (images_.size() > kMaxWaiting) {
    images_.pop_front();
    ++unpaired_;
  }
  return Match();
}

std::optional<ImageAndDepth> DepthPairer::AddDepth(RawFrame depth) {
  depths_.push_back(std::move(depth));
  if (depths_.size() > kMaxWaiting) {
    depths_.pop_front();
    ++unpaired_;
  }
  return Match();
}

}  // namespace gw::camera

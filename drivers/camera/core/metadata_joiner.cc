#include "drivers/camera/core/metadata_joiner.h"

namespace gw::camera {
namespace {

// The signed distance of two sequence numbers, which wrap around.
int32_t Difference(uint32_t a, uint32_t b) {
  return static_cast<int32_t>(a - b);
}

}  // namespace

std::vector<RawFrame> MetadataJoiner::AddImage(RawFrame frame) {
  images_.push_back(std::move(frame));
  return TakeComplete();
}

std::vector<RawFrame> MetadataJoiner::AddMetadata(uint32_t sequence,
                                                  const FrameMetadata& metadata) {
  metadata_.emplace_back(sequence, metadata);
  if (metadata_.size() > kMaxWaiting) metadata_.pop_front();
  return TakeComplete();
}

std::vector<RawFrame> MetadataJoiner::TakeComplete() {
  std::vector<RawFrame> out;
  while (!images_.empty()) {
    RawFrame& image = images_.front();
    while (!metadata_.empty() && Difference(metadata_.front().first, image.sequence) < 0) {
      metadata_.pop_front();
    }
    const bool found = !metadata_.empty() && metadata_.front().first == image.sequence;
    const bool overtaken = images_.size() > 1 || (!metadata_.empty() && !found);
    if (has_metadata_ && !found && !overtaken) break;
    if (found) {
      image.metadata = metadata_.front().second;
      metadata_.pop_front();
    } else if (has_metadata_) {
      ++without_metadata_;
    }
    out.push_back(std::move(image));
    images_.pop_front();
  }
  return out;
}

}  // namespace gw::camera

// Joins the images of a video node with the buffers of its metadata node, by sequence number. The
// two arrive in any order; kernels leave metadata out now and then.
#pragma once

#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/camera/core/raw_frame.h"

namespace gw::camera {

class MetadataJoiner {
 public:
  // Without metadata (`has_metadata` false) images pass as they come.
  explicit MetadataJoiner(bool has_metadata) : has_metadata_(has_metadata) {}

  // Each call gives the images that are complete now, in order: with their metadata, or without
  // when a later image or later metadata came first.
  std::vector<RawFrame> AddImage(RawFrame frame);
  std::vector<RawFrame> AddMetadata(uint32_t sequence, const FrameMetadata& metadata);

  int64_t without_metadata() const { return without_metadata_; }

 private:
  std::vector<RawFrame> TakeComplete();

  static constexpr size_t kMaxWaiting = 16;  // metadata buffers whose image was lost

  bool has_metadata_;
  std::deque<RawFrame> images_;
  std::deque<std::pair<uint32_t, FrameMetadata>> metadata_;
  int64_t without_metadata_ = 0;
};

}  // namespace gw::camera

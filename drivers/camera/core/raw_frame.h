// One image as it came out of a video node, with what its metadata node said about it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/core/time.h"
#include "drivers/camera/protocol/metadata.h"

namespace gw::camera {

struct RawFrame {
  uint32_t sequence = 0;  // counts the frames of the stream, also those that were lost
  Utime arrival;          // arrival of the first bytes, on the host's clock
  std::optional<FrameMetadata> metadata;
  std::vector<uint8_t> pixels;
};

}  // namespace gw::camera

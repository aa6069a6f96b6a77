// One buffer of a UVC metadata node: what the camera says about a frame.
//
// Layout: a host part of 10 bytes (u64 time ns, u16 USB frame number), the UVC payload header
// (length, flags, PTS, SCR) and, on D4xx cameras with a kernel that knows V4L2_META_FMT_D4XX,
// blocks of {u32 id, u32 size, fields}. Kernel documentation: metafmt-uvc, metafmt-d4xx. Debian
// 12's 6.1 offers only the header ('UVCH') for a D435i; 6.12 offers the blocks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/core/result.h"
#include "drivers/camera/protocol/image_format.h"

namespace gw::camera {

inline constexpr uint32_t kMetaUvc = Fourcc('U', 'V', 'C', 'H');
inline constexpr uint32_t kMetaD4xx = Fourcc('D', '4', 'X', 'X');

struct FrameMetadata {
  int64_t host_ns = 0;             // start of the payload, CLOCK_MONOTONIC
  std::optional<uint32_t> pts_us;  // device clock (D4xx), wraps after 71.6 min
  // The following come from the blocks of D4xx cameras; each is empty when its block, or the field
  // in it, is not there.
  std::optional<uint32_t> frame_counter;
  std::optional<uint32_t> to_mid_exposure_us;  // PTS minus this is the middle of the exposure
  std::optional<uint32_t> exposure_us;
  std::optional<uint32_t> gain;
  std::optional<uint32_t> laser_power_mw;
  std::optional<bool> emitter_on;  // what the camera claims, which need not be true
};

// Reads a metadata buffer. Error kBadData: it is shorter than its header, or a block reaches beyond
// its end. Unknown blocks are skipped, and a header without PTS is fine.
Result<FrameMetadata> ParseMetadata(std::span<const uint8_t> bytes);

}  // namespace gw::camera

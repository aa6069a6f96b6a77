#include "drivers/camera/protocol/metadata.h"

#include <algorithm>
#include <string>

#include "drivers/common/bytes.h"

namespace gw::camera {
namespace {

constexpr size_t kHostBytes = 10;    // bytes of the host part before the payload header
constexpr size_t kHeaderBytes = 12;  // bytes of a payload header with PTS and SCR
constexpr uint8_t kHasPts = 0x04;
constexpr size_t kBlockHeaderBytes = 8;

constexpr uint32_t kDepthControl = 0x80000000;
constexpr uint32_t kCaptureTiming = 0x80000001;

// A block: its fields lie behind {id, size, version, flags}, and bit i of the flags announces a
// field.
class Block {
 public:
  explicit Block(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  uint32_t id() const { return ReadU32(bytes_, 0); }
  std::optional<uint32_t> U32(uint32_t flag, size_t at) const {
    if (!Has(flag, at + 4)) return std::nullopt;
    return ReadU32(bytes_, at);
  }
  std::optional<uint8_t> U8(uint32_t flag, size_t at) const {
    if (!Has(flag, at + 1)) return std::nullopt;
    return bytes_[at];
  }

 private:
  bool Has(uint32_t flag, size_t end) const {
    return bytes_.size() >= 16 && bytes_.size() >= end && (ReadU32(bytes_, 12) & flag) != 0;
  }
  std::span<const uint8_t> bytes_;
};

void ReadBlock(const Block& block, FrameMetadata* out) {
  if (block.id() == kCaptureTiming) {
    out->frame_counter = block.U32(0x01, 16);
    out->to_mid_exposure_us = block.U32(0x02, 20);
    out->exposure_us = block.U32(0x08, 28);
  } else if (block.id() == kDepthControl) {
    out->gain = block.U32(0x01, 16);
    // The capture timing is the better source, since it is that of this frame.
    if (!out->exposure_us) out->exposure_us = block.U32(0x02, 20);
    out->laser_power_mw = block.U32(0x04, 24);
    if (const auto mode = block.U8(0x80, 56)) out->emitter_on = *mode != 0;
  }
}

}  // namespace

Result<FrameMetadata> ParseMetadata(std::span<const uint8_t> bytes) {
  if (bytes.size() < kHostBytes + 2) {
    return Error{ErrorCode::kBadData, "metadata of " + std::to_string(bytes.size()) + " bytes"};
  }
  FrameMetadata out;
  out.host_ns = static_cast<int64_t>(ReadU64(bytes, 0));
  const uint8_t flags = bytes[kHostBytes + 1];
  // The kernel copies the camera's length byte even when it cuts the blocks off.
  const size_t end = std::min(bytes.size(), kHostBytes + bytes[kHostBytes]);
  if ((flags & kHasPts) != 0) {
    if (end < kHostBytes + 6) {
      return Error{ErrorCode::kBadData, "metadata claim a time stamp but end before it"};
    }
    out.pts_us = ReadU32(bytes, kHostBytes + 2);
  }
  size_t at = kHostBytes + kHeaderBytes;
  while (at + kBlockHeaderBytes <= end) {
    const uint32_t size = ReadU32(bytes, at + 4);
    if (size < kBlockHeaderBytes || size > end - at) {
      return Error{ErrorCode::kBadData,
                   "metadata block of " + std::to_string(size) + " bytes reaches beyond the end"};
    }
    ReadBlock(Block(bytes.subspan(at, size)), &out);
    at += size;
  }
  return out;
}

}  // namespace gw::camera

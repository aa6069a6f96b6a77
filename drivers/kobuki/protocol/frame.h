// The frame of the Kobuki serial link, the same in both directions: AA 55 L payload[L] checksum,
// checksum = XOR of L and the payload; the payload is a row of sub-payloads id, len, data[len].
// AA 55 is not escaped and may stand inside a payload.
// Source: Kobuki protocol, yujinrobot kobuki_driver documentation; FrameParser says how to
// resynchronise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gw::kobuki {

inline constexpr uint8_t kHeader0 = 0xAA;
inline constexpr uint8_t kHeader1 = 0x55;
inline constexpr size_t kMinPayload = 3;     // one sub-payload of one byte
inline constexpr size_t kFrameOverhead = 4;  // two headers, length, checksum
// The largest frame of a real robot, with every requested answer in it, stays below 140 bytes; a
// larger length is a false header, and believing it would hold back up to three true frames.
inline constexpr size_t kMaxPayload = 200;

struct SubPayload {
  uint8_t id = 0;
  std::span<const uint8_t> data;
};

// The sub-payloads of a payload, pointing into it. Empty when they do not fill it exactly or one is
// empty: then the payload is corrupt, and no part of it can be trusted.
std::optional<std::vector<SubPayload>> SplitPayload(std::span<const uint8_t> payload);

// Precondition: kMinPayload <= payload.size() <= 255.
std::vector<uint8_t> EncodeFrame(std::span<const uint8_t> payload);

struct Frame {
  std::vector<uint8_t> payload;  // a payload that SplitPayload() accepts
  // Bytes that had arrived behind the frame when it was found. The line is serial: the frame's last
  // byte came at least that many byte times before the newest byte.
  size_t bytes_after = 0;
};

struct FrameCounters {
  int64_t bytes = 0;
  int64_t frames = 0;
  int64_t skipped_bytes = 0;  // bytes that belong to no frame
  int64_t bad_length = 0;     // headers that an impossible length follows
  // Wrong checksums, and right ones by chance: a later frame begins inside.
  int64_t bad_checksum = 0;
  int64_t malformed = 0;  // payloads with a right checksum that are no row of sub-payloads
};

// Finds frames in a byte stream, whatever its pieces. After anything that is no frame it drops only
// the first byte of the attempt and looks again from the next one, so that a lost or changed byte
// costs the frame that it belongs to and not the next. The checksum has only 8 bits: the header of
// a damaged frame may claim the begin of the true one behind it and be right by chance. So a frame
// gives way to one that begins inside it and is right as well; a frame with a header among its
// bytes is delivered when that header has proved false, at most one such frame later.
class FrameParser {
 public:
  // The frames that these bytes complete, in order.
  std::vector<Frame> Push(std::span<const uint8_t> bytes);

  // Gives up the waiting attempt and gives the true frames that it held back; to be called when the
  // stream paused inside a frame for so long that the rest will not come.
  std::vector<Frame> AbandonPartial();

  bool has_partial() const { return !buffer_.empty(); }
  const FrameCounters& counters() const { return counters_; }

 private:
  std::vector<Frame> Scan(bool more_will_come);

  std::vector<uint8_t> buffer_;
  FrameCounters counters_;
};

}  // namespace gw::kobuki

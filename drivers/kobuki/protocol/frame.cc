#include "drivers/kobuki/protocol/frame.h"

#include "common/core/check.h"

namespace gw::kobuki {
namespace {

uint8_t Xor(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (const uint8_t byte : bytes) sum ^= byte;
  return sum;
}

}  // namespace

std::optional<std::vector<SubPayload>> SplitPayload(std::span<const uint8_t> payload) {
  std::vector<SubPayload> out;
  while (!payload.empty()) {
    if (payload.size() < kMinPayload) return std::nullopt;
    const size_t length = payload[1];
    if (length == 0 || 2 + length > payload.size()) return std::nullopt;
    out.push_back({payload[0], payload.subspan(2, length)});
    payload = payload.subspan(2 + length);
  }
  return out;
}

std::vector<uint8_t> EncodeFrame(std::span<const uint8_t> payload) {
  GW_CHECK(payload.size() >= kMinPayload && payload.size() <= 255);
  std::vector<uint8_t> out = {kHeader0, kHeader1, static_cast<uint8_t>(payload.size())};
  out.insert(out.end(), payload.begin(), payload.end());
  out.push_back(Xor(std::span(out).subspan(2)));
  return out;
}

std::vector<Frame> FrameParser::Push(std::span<const uint8_t> bytes) {
  counters_.bytes += static_cast<int64_t>(bytes.size());
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return Scan(true);
}

std::vector<Frame> FrameParser::AbandonPartial() {
  return Scan(false);
}

// What the bytes from the first of `rest` on are. kTaken: a frame of `*size` bytes.
FrameParser::Attempt FrameParser::Try(std::span<const uint8_t> rest, size_t* size) {
  if (rest[0] != kHeader0) return Attempt::kRefused;
  if (rest.size() < 2) return Attempt::kIncomplete;
  if (rest[1] != kHeader1) return Attempt::kRefused;
  if (rest.size() < 3) return Attempt::kIncomplete;
  const size_t length = rest[2];
  if (length < kMinPayload || length > kMaxPayload) {
    ++counters_.bad_length;
    return Attempt::kRefused;
  }
  *size = length + kFrameOverhead;
  if (rest.size() < *size) return Attempt::kIncomplete;
  if (Xor(rest.subspan(2, length + 2)) != 0) {
    ++counters_.bad_checksum;
    return Attempt::kRefused;
  }
  if (!SplitPayload(rest.subspan(3, length))) {
    ++counters_.malformed;
    return Attempt::kRefused;
  }
  // A checksum that looks like a header: when a byte of the last sub-payload was lost, it is the
  // header of the next frame, taken for the checksum. One chance in 256 would make both frames
  // wrong, so the next byte decides.
  if (rest[*size - 1] == kHeader0) {
    if (rest.size() == *size) return Attempt::kTakenUnlessHeader;
    if (rest[*size] == kHeader1) {
      ++counters_.bad_checksum;
      return Attempt::kRefused;
    }
  }
  return Attempt::kTaken;
}

std::vector<Frame> FrameParser::Scan(bool more_will_come) {
  std::vector<Frame> out;
  const std::span<const uint8_t> all(buffer_);
  size_t begin = 0;
  while (begin < all.size()) {
    const std::span<const uint8_t> rest = all.subspan(begin);
    size_t size = 0;
    const Attempt attempt = Try(rest, &size);
    const bool waits = attempt == Attempt::kIncomplete || attempt == Attempt::kTakenUnlessHeader;
    if (waits && more_will_come) break;
    if (attempt == Attempt::kTaken || attempt == Attempt::kTakenUnlessHeader) {
      begin += size;
      ++counters_.frames;
      const auto payload = rest.subspan(3, size - kFrameOverhead);
      out.push_back({{payload.begin(), payload.end()}, all.size() - begin});
    } else {
      ++counters_.skipped_bytes;
      ++begin;
    }
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<ptrdiff_t>(begin));
  return out;
}

}  // namespace gw::kobuki

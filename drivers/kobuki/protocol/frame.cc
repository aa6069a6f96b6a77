#include "drivers/kobuki/protocol/frame.h"

#include "common/core/check.h"

namespace gw::kobuki {
namespace {

uint8_t Xor(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (const uint8_t byte : bytes) sum ^= byte;
  return sum;
}

enum class Attempt { kNoHeader, kBadLength, kBadChecksum, kMalformed, kIncomplete, kFrame };

// Says what the bytes from the first of `rest` on are.
Attempt Try(std::span<const uint8_t> rest) {
  if (rest[0] != kHeader0) return Attempt::kNoHeader;
  if (rest.size() < 2) return Attempt::kIncomplete;
  if (rest[1] != kHeader1) return Attempt::kNoHeader;
  if (rest.size() < 3) return Attempt::kIncomplete;
  const size_t length = rest[2];
  if (length < kMinPayload || length > kMaxPayload) return Attempt::kBadLength;
  if (rest.size() < length + kFrameOverhead) return Attempt::kIncomplete;
  if (Xor(rest.subspan(2, length + 2)) != 0) return Attempt::kBadChecksum;
  return SplitPayload(rest.subspan(3, length)) ? Attempt::kFrame : Attempt::kMalformed;
}

// The same, but a frame gives way to one that begins inside it.
Attempt TryAgainstLater(std::span<const uint8_t> rest, bool more_will_come) {
  const Attempt attempt = Try(rest);
  if (attempt != Attempt::kFrame) return attempt;
  bool undecided = false;
  for (size_t i = 1; i < rest[2] + kFrameOverhead; ++i) {
    const Attempt inner = Try(rest.subspan(i));
    if (inner == Attempt::kFrame) return Attempt::kBadChecksum;
    undecided |= inner == Attempt::kIncomplete;
  }
  return undecided && more_will_come ? Attempt::kIncomplete : Attempt::kFrame;
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

std::vector<Frame> FrameParser::Scan(bool more_will_come) {
  std::vector<Frame> out;
  const std::span<const uint8_t> all(buffer_);
  size_t begin = 0;
  while (begin < all.size()) {
    const std::span<const uint8_t> rest = all.subspan(begin);
    const Attempt attempt = TryAgainstLater(rest, more_will_come);
    if (attempt == Attempt::kIncomplete && more_will_come) break;
    if (attempt == Attempt::kFrame) {
      const auto payload = rest.subspan(3, rest[2]);
      begin += payload.size() + kFrameOverhead;
      ++counters_.frames;
      out.push_back({{payload.begin(), payload.end()}, all.size() - begin});
      continue;
    }
    counters_.bad_length += attempt == Attempt::kBadLength;
    counters_.bad_checksum += attempt == Attempt::kBadChecksum;
    counters_.malformed += attempt == Attempt::kMalformed;
    ++counters_.skipped_bytes;
    ++begin;
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<ptrdiff_t>(begin));
  return out;
}

}  // namespace gw::kobuki

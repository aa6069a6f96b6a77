#include "drivers/camera/protocol/iio_buffer.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "common/core/check.h"

namespace gw::camera {
namespace {

int64_t DecodeChannel(const IioChannel& channel, std::span<const uint8_t> bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < bytes.size(); ++i) {
    const size_t place = channel.little_endian ? i : bytes.size() - 1 - i;
    value |= static_cast<uint64_t>(bytes[i]) << (8 * place);
  }
  value >>= channel.shift;
  const int unused = 64 - channel.bits;
  value <<= unused;
  return channel.is_signed ? static_cast<int64_t>(value) >> unused
                           : static_cast<int64_t>(value >> unused);
}

}  // namespace

Result<IioChannel> ParseIioChannel(const std::string& name, const std::string& index,
                                   const std::string& type) {
  IioChannel out;
  out.name = name;
  char endian = 0, sign = 0;
  const int fields = std::sscanf(type.c_str(), "%ce:%c%d/%d>>%d", &endian, &sign, &out.bits,
                                 &out.storage_bits, &out.shift);
  const auto parsed = std::from_chars(index.data(), index.data() + index.size(), out.index);
  const bool sizes = out.storage_bits == 8 || out.storage_bits == 16 || out.storage_bits == 32 ||
                     out.storage_bits == 64;
  if (fields != 5 || parsed.ec != std::errc() || out.index < 0 ||
      (endian != 'l' && endian != 'b') || (sign != 's' && sign != 'u') || !sizes || out.bits < 1 ||
      out.shift < 0 || out.bits + out.shift > out.storage_bits) {
    return Error{ErrorCode::kBadData, name + ": channel of index \"" + index + "\" and type \"" +
                                          type + "\" is not understood"};
  }
  out.little_endian = endian == 'l';
  out.is_signed = sign == 's';
  return out;
}

Result<IioLayout> IioLayout::Create(std::vector<IioChannel> channels) {
  if (channels.empty()) return Error{ErrorCode::kBadData, "no channel is enabled"};
  std::sort(channels.begin(), channels.end(),
            [](const IioChannel& a, const IioChannel& b) { return a.index < b.index; });
  IioLayout layout;
  size_t end = 0, largest = 1;
  for (size_t i = 0; i < channels.size(); ++i) {
    if (i > 0 && channels[i].index == channels[i - 1].index) {
      return Error{ErrorCode::kBadData,
                   channels[i].name + " and " + channels[i - 1].name + " have the same index"};
    }
    const auto size = static_cast<size_t>(channels[i].storage_bits) / 8;
    const size_t offset = (end + size - 1) / size * size;
    layout.channels_.push_back({channels[i], offset});
    end = offset + size;
    largest = std::max(largest, size);
  }
  layout.row_bytes_ = (end + largest - 1) / largest * largest;
  return layout;
}

int IioLayout::Find(const std::string& name) const {
  for (size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].channel.name == name) return static_cast<int>(i);
  }
  return -1;
}

std::vector<int64_t> IioLayout::Decode(std::span<const uint8_t> row) const {
  GW_CHECK(row.size() == row_bytes_);
  std::vector<int64_t> out;
  for (const Placed& placed : channels_) {
    out.push_back(DecodeChannel(
        placed.channel,
        row.subspan(placed.offset, static_cast<size_t>(placed.channel.storage_bits) / 8)));
  }
  return out;
}

}  // namespace gw::camera

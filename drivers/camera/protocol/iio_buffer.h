// The buffer of an industrial I/O device: rows of channels, as scan_elements/*_type and *_index in
// sysfs describe them. Kernel documentation: iio/iio_devbuf.
//
// Channels lie in order of their index, each aligned to its own size; the row is padded to the
// largest.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::camera {

struct IioChannel {
  std::string name;  // "in_accel_x", "in_timestamp"
  int index = 0;     // place in the order of a row
  bool little_endian = true;
  bool is_signed = true;
  int bits = 0;          // bits of the value that count
  int storage_bits = 0;  // 8, 16, 32 or 64
  int shift = 0;         // shift to the right before the bits are taken
};

// Reads the description of a channel; `type` is of the form "le:s32/32>>0". Error kBadData: it is
// not, or the bits do not fit.
Result<IioChannel> ParseIioChannel(const std::string& name, const std::string& index,
                                   const std::string& type);

class IioLayout {
 public:
  // Lays out the enabled channels, which may come in any order. Error kBadData: two have one index,
  // or there are none.
  static Result<IioLayout> Create(std::vector<IioChannel> channels);

  size_t row_bytes() const { return row_bytes_; }
  // The place of a channel in what Decode() gives; -1 when it is not enabled.
  int Find(const std::string& name) const;
  // Reads one row as numbers, in order of index. Precondition: row.size() == row_bytes().
  std::vector<int64_t> Decode(std::span<const uint8_t> row) const;

 private:
  struct Placed {
    IioChannel channel;
    size_t offset = 0;
  };
  std::vector<Placed> channels_;
  size_t row_bytes_ = 0;
};

}  // namespace gw::camera

// The compressions that bags use.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/data/bag/byte_cursor.h"

namespace gw::bag {

struct Decompressed {
  std::vector<uint8_t> bytes;  // all that could be decompressed, also of an input that was cut off
  std::string problem;         // empty: the input was whole
};

// compression: "" or "none", "bz2", "lz4" (frames of LZ4 Frame Format, as MCAP and ROS 1 have
// them), "zstd". At most `limit` bytes come out: a damaged length in front must not fill memory.
Decompressed Decompress(const std::string& compression, Bytes input, uint64_t limit);

}  // namespace gw::bag

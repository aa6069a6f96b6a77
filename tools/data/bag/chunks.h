// The chunks of a bag: compressed where they lie in the file, and those that were asked for last
// decompressed.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/data/bag/byte_cursor.h"

namespace gw::bag {

struct Chunk {
  Bytes data;
  std::string compression;  // as Decompress knows it
  uint64_t size = 0;        // decompressed, as the file says
};

class Chunks {
 public:
  // `file`: the records outside of chunks, which are block 0. At most `largest` bytes are made of a
  // chunk: that bounds what damage may claim. What is referred to has to stay.
  Chunks(Bytes file, uint64_t largest) : file_(file), largest_(largest) {}

  // Files the chunk at this position of the file, > 0, and decompresses it. `problem`: empty where
  // it was whole.
  struct Added {
    Bytes bytes;
    std::string problem;
  };
  Added Add(uint64_t position, const Chunk& chunk);

  // The bytes of block 0 or of the chunk that was added at this position; valid until the next
  // call.
  Bytes Block(uint64_t position);

 private:
  struct Unpacked {
    uint64_t position = 0;  // 0: none
    std::vector<uint8_t> bytes;
  };
  // Decompresses a chunk in the place of the one that was so the longest.
  Added Unpack(uint64_t position);

  Bytes file_;
  uint64_t largest_;
  std::map<uint64_t, Chunk> chunks_;  // by position
  // Two images of one instant lie in one chunk or in neighbouring ones; four are enough for them.
  std::array<Unpacked, 4> unpacked_;
  size_t next_ = 0;
};

}  // namespace gw::bag

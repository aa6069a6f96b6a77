#include "tools/data/bag/chunks.h"

#include <algorithm>
#include <utility>

#include "tools/data/bag/decompress.h"

namespace gw::bag {

Chunks::Added Chunks::Add(uint64_t position, const Chunk& chunk) {
  chunks_[position] = chunk;
  return Unpack(position);
}

Bytes Chunks::Block(uint64_t position) {
  if (position == 0) return file_;
  for (const Unpacked& unpacked : unpacked_) {
    if (unpacked.position == position) return unpacked.bytes;
  }
  return Unpack(position).bytes;
}

Chunks::Added Chunks::Unpack(uint64_t position) {
  const Chunk& chunk = chunks_.at(position);
  Decompressed whole = Decompress(chunk.compression, chunk.data, std::min(chunk.size, largest_));
  Unpacked& unpacked = unpacked_[next_];
  next_ = (next_ + 1) % unpacked_.size();
  unpacked = {position, std::move(whole.bytes)};
  return {unpacked.bytes, std::move(whole.problem)};
}

}  // namespace gw::bag

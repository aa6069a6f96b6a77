// The chunks that were decompressed last.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace gw::bag {

// Two images of one instant lie in one chunk or in neighbouring ones; four are enough for them.
class ChunkCache {
 public:
  // The chunk at this position of the file; load() makes it when it is not there.
  template <typename Load>
  const std::vector<uint8_t>& Get(uint64_t position, Load load) {
    for (const Entry& entry : entries_) {
      if (entry.used && entry.position == position) return entry.bytes;
    }
    Entry& entry = entries_[next_];
    next_ = (next_ + 1) % entries_.size();
    entry = {true, position, load()};
    return entry.bytes;
  }

 private:
  struct Entry {
    bool used = false;
    uint64_t position = 0;
    std::vector<uint8_t> bytes;
  };
  std::array<Entry, 4> entries_;
  size_t next_ = 0;
};

}  // namespace gw::bag

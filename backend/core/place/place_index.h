// Which keyframes look like this image? An index over binary descriptors that needs no training
// (ADR 6 compares it with a vocabulary tree).
//
// Multi-index hashing (Norouzi, Punjani, Fleet 2012): a descriptor is filed under kTables disjoint
// groups of its bits. Descriptors that agree in all bits of a group are compared in full; within
// kMaxDistance they are taken for sights of the same point. A feature that many keyframes answer
// says little: it counts with log(keyframes / answers), as in text retrieval.
//
// What shares a group lies side by side in memory, and a query asks in the order in which it lies:
// one that jumps about in a memory larger than the caches would wait for most of what it reads.
// New places are merged in by and by.
//
// Pure and deterministic; grows and shrinks with the map. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/contract/map.h"

namespace gw::backend {

struct PlaceScore {
  KeyframeId keyframe;
  double score = 0;     // [0, 1]: share of the query's weight that the keyframe answers
  int num_matches = 0;  // features of the query that it answers
};

// A keyframe to be filed; the descriptors are copied.
struct Place {
  KeyframeId keyframe;
  const std::vector<Descriptor>& descriptors;
};

class PlaceIndex {
 public:
  static constexpr size_t kMaxFeatures = size_t{1} << 16;
  static constexpr int kMaxDistance = 32;  // of 256 bits; 28 to 36 serve as well (ADR 6)

  // Replaces what was filed under the ids. A whole map at once takes a quarter of the time that its
  // keyframes take one by one. Precondition: no id twice.
  void Insert(std::span<const Place> places);
  void Insert(const Place& place) { Insert(std::span(&place, 1)); }
  // No effect when the id is not there.
  void Erase(KeyframeId id);

  // Every keyframe that answers at least one feature: best score first, then oldest. Precondition:
  // at most kMaxFeatures descriptors.
  std::vector<PlaceScore> Query(const std::vector<Descriptor>& descriptors) const;

  size_t size() const { return blocks_.size(); }

 private:
  static constexpr int kTables = 16;
  static constexpr int kBits = 16;  // of a group; kTables * kBits = 256

  // Where a descriptor belongs: keyframe slot and feature. `sketch` are 32 more of its bits: most
  // of what shares a group by chance is told apart without fetching the descriptor.
  struct Entry {
    uint32_t slot = 0;
    uint16_t feature = 0;
    uint16_t sketch = 0;
  };
  struct Block {
    KeyframeId id;
    std::vector<Descriptor> descriptors;
  };

  struct Filed {
    uint16_t key;
    Entry entry;
  };
  // The entries of one group of bits. Those of a place that was erased stay until the next Settle.
  struct Table {
    std::vector<uint32_t> begin;  // of each key in `entries`, and the end of the last; or empty
    std::vector<Entry> entries;
    std::vector<Filed> recent;  // by key; not in `entries` yet
  };

  void Settle();
  void SettleTable(Table& table);

  // The steps of a query, see Query().
  class Answers;
  class Question;

  std::map<KeyframeId, uint32_t> blocks_;  // slot of each keyframe
  std::vector<Block> slots_;
  std::vector<uint8_t> erased_;  // slots whose entries may still be there
  std::vector<uint32_t> free_slots_;
  size_t num_recent_ = 0;  // places
  size_t num_erased_ = 0;
  std::array<Table, kTables> tables_;
};

}  // namespace gw::backend

// Which keyframes look like this image? An index over binary descriptors that needs no training
// (ADR 6 compares it with a vocabulary tree).
//
// Multi-index hashing (Norouzi, Punjani, Fleet 2012): a descriptor is filed under kTables disjoint
// groups of its bits. Descriptors that agree in all bits of a group are compared in full; within
// kMaxDistance they are taken for sights of the same point. A feature that many keyframes answer
// says little: it counts with log(keyframes / answers), as in text retrieval.
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
  static constexpr int kMaxDistance = 32;  // of 256 bits; 28 to 36 serve as well (ADR 6)

  // Replaces what was filed under the ids. A whole map at once takes a quarter of the time that its
  // keyframes take one by one. Precondition: no id twice.
  void Insert(std::span<const Place> places);
  void Insert(const Place& place) { Insert(std::span(&place, 1)); }
  // No effect when the id is not there.
  void Erase(KeyframeId id);

  // Every keyframe that answers at least one feature: best score first, then oldest.
  std::vector<PlaceScore> Query(const std::vector<Descriptor>& descriptors) const;

  size_t size() const { return blocks_.size(); }

 private:
  static constexpr int kTables = 16;
  static constexpr int kBits = 16;  // of a group; kTables * kBits = 256

  // A descriptor's place: keyframe slot and feature. `sketch` are 32 more of its bits: most of what
  // shares a group by chance is told apart without fetching the descriptor.
  struct Entry {
    uint32_t slot = 0;
    uint16_t feature = 0;
    uint16_t sketch = 0;
  };
  struct Block {
    KeyframeId id;
    std::vector<Descriptor> descriptors;
  };

  static constexpr size_t kEntriesPerLine = 64 / sizeof(Entry);  // of the cache

  uint32_t TakeSlot();
  std::vector<Entry>& Bucket(int table, uint16_t key) {
    return buckets_[static_cast<size_t>(table) << kBits | key];
  }
  const std::vector<Entry>& Bucket(int table, uint16_t key) const {
    return buckets_[static_cast<size_t>(table) << kBits | key];
  }

  // The steps of a query, see Query().
  struct Lookup;
  struct Answers;
  void FetchBuckets(const Descriptor& descriptor, Lookup& lookup) const;
  void FetchEntries(const Lookup& lookup) const;
  // alike: the entries of a table that share a group with the feature and resemble it in their
  // sketch, but for the slots that have answered it.
  void FetchDescriptors(const Lookup& lookup, int table, size_t query, const Answers& answers,
                        std::vector<Entry>& alike) const;
  void Compare(const Descriptor& descriptor, size_t query, const std::vector<Entry>& alike,
               Answers& answers) const;
  void Ask(const Descriptor& descriptor, size_t query, const Lookup& lookup,
           std::array<std::vector<Entry>, 2>& alike, Answers& answers) const;

  std::map<KeyframeId, uint32_t> blocks_;  // slot of each keyframe
  std::vector<Block> slots_;
  std::vector<uint32_t> free_slots_;
  std::vector<std::vector<Entry>> buckets_ =
      std::vector<std::vector<Entry>>(static_cast<size_t>(kTables) << kBits);
};

}  // namespace gw::backend

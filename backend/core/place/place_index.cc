#include "backend/core/place/place_index.h"

#include <algorithm>
#include <cmath>

namespace gw::backend {
namespace {

// Greatest Hamming distance of two groups of 16 bits that are compared further. A true match (at
// most 32 of 256 bits) differs in 2 of the 16 on average, chance in 8.
constexpr int kMaxSketchDistance = 5;

// Group t holds bits t, t + 16, t + 32, ...: neighbouring bits of a descriptor may be related. So
// the groups are the columns of the bits written in 16 rows: a matrix of bits is transposed, block
// by block (Warren, Hacker's Delight, 7-3).
std::array<uint16_t, 16> Groups(const Descriptor& descriptor) {
  std::array<uint16_t, 16> out;
  for (int row = 0; row < 16; ++row) {
    out[row] = static_cast<uint16_t>(descriptor[row / 4] >> (16 * (row % 4)));
  }
  uint32_t mask = 0x00FF;  // the columns of a block's left half
  for (int size = 8; size > 0; size /= 2, mask ^= mask << size) {
    for (int row = 0; row < 16; row = (row + size + 1) & ~size) {
      const uint32_t swap = (static_cast<uint32_t>(out[row]) >> size ^ out[row + size]) & mask;
      out[row] = static_cast<uint16_t>(out[row] ^ swap << size);
      out[row + size] = static_cast<uint16_t>(out[row + size] ^ swap);
    }
  }
  return out;
}

// For entries of table t: another group.
uint16_t SketchFor(const std::array<uint16_t, 16>& groups, int table) {
  return groups[(table + 1) % 16];
}

}  // namespace

uint32_t PlaceIndex::TakeSlot() {
  if (free_slots_.empty()) {
    slots_.emplace_back();
    return static_cast<uint32_t>(slots_.size() - 1);
  }
  const uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

void PlaceIndex::Insert(std::span<const Place> places) {
  struct Filed {
    uint32_t slot;
    uint16_t feature;
    std::array<uint16_t, 16> groups;
  };
  std::vector<Filed> filed;
  for (const Place& place : places) {
    Erase(place.keyframe);
    const uint32_t slot = TakeSlot();
    blocks_[place.keyframe] = slot;
    slots_[slot] = {place.keyframe, place.descriptors};
    for (size_t i = 0; i < place.descriptors.size(); ++i) {
      filed.push_back({slot, static_cast<uint16_t>(i), Groups(place.descriptors[i])});
    }
  }
  // Table by table, new buckets in their size at once: the memory at work stays small.
  std::vector<uint32_t> count(size_t{1} << kBits);
  for (int table = 0; table < kTables; ++table) {
    for (const Filed& f : filed) ++count[f.groups[table]];
    for (const Filed& f : filed) {
      const uint16_t key = f.groups[table];
      std::vector<Entry>& bucket = Bucket(table, key);
      if (bucket.empty()) bucket.reserve(count[key]);
      count[key] = 0;
      bucket.push_back({f.slot, f.feature, SketchFor(f.groups, table)});
    }
  }
}

void PlaceIndex::Erase(KeyframeId id) {
  const auto it = blocks_.find(id);
  if (it == blocks_.end()) return;
  const uint32_t slot = it->second;
  for (const Descriptor& descriptor : slots_[slot].descriptors) {
    const auto groups = Groups(descriptor);
    for (int table = 0; table < kTables; ++table) {
      std::erase_if(Bucket(table, groups[table]),
                    [slot](const Entry& entry) { return entry.slot == slot; });
    }
  }
  slots_[slot] = {};
  free_slots_.push_back(slot);
  blocks_.erase(it);
}

// A feature of the query on its way through the index. Every step of the way (the buckets, their
// entries, the descriptors of those that are told apart no further) lies elsewhere in a memory much
// larger than the caches: a step asks for what the next one reads, and others are done meanwhile.
struct PlaceIndex::Lookup {
  std::array<uint16_t, kTables> groups;
  std::vector<Entry> alike;  // entries that share a group and resemble the feature in their sketch
};

// The newest feature of the query, and of the slot, that were put together: what agrees in several
// groups is compared once.
struct PlaceIndex::Pairing {
  uint32_t query = 0xFFFFFFFF;
  uint32_t feature = 0;
};

void PlaceIndex::FetchBuckets(const Descriptor& descriptor, Lookup& lookup) const {
  lookup.groups = Groups(descriptor);
  for (int table = 0; table < kTables; ++table) {
    __builtin_prefetch(&Bucket(table, lookup.groups[table]));
  }
}

void PlaceIndex::FetchEntries(const Lookup& lookup) const {
  for (int table = 0; table < kTables; ++table) {
    const std::vector<Entry>& bucket = Bucket(table, lookup.groups[table]);
    for (size_t i = 0; i < bucket.size(); i += kEntriesPerLine) __builtin_prefetch(&bucket[i]);
  }
}

void PlaceIndex::FetchDescriptors(uint32_t query, Lookup& lookup,
                                  std::vector<Pairing>& pairings) const {
  lookup.alike.clear();
  for (int table = 0; table < kTables; ++table) {
    const std::vector<Entry>& bucket = Bucket(table, lookup.groups[table]);
    const uint16_t sketch = SketchFor(lookup.groups, table);
    // One in ten resembles it, which no processor foretells: a branch would cost more than writing
    // them all.
    const size_t begin = lookup.alike.size();
    lookup.alike.resize(begin + bucket.size());
    size_t end = begin;
    for (const Entry& entry : bucket) {
      lookup.alike[end] = entry;
      end += __builtin_popcount(entry.sketch ^ sketch) <= kMaxSketchDistance ? 1 : 0;
    }
    const size_t seen = end;
    end = begin;
    for (size_t i = begin; i < seen; ++i) {
      const Entry entry = lookup.alike[i];
      Pairing& pairing = pairings[entry.slot];
      if (pairing.query == query && pairing.feature == entry.feature) continue;
      pairing = {query, entry.feature};
      lookup.alike[end++] = entry;
      __builtin_prefetch(slots_[entry.slot].descriptors.data() + entry.feature);
    }
    lookup.alike.resize(end);
  }
}

std::vector<PlaceScore> PlaceIndex::Query(const std::vector<Descriptor>& descriptors) const {
  struct Tally {
    double weight = 0;
    int matches = 0;
    size_t answered = 0;  // 1 + newest feature of the query that it answered
  };
  std::vector<Tally> tally(slots_.size());
  std::vector<uint32_t> answers;
  const double num_keyframes = static_cast<double>(blocks_.size());
  double total = 0;
  const auto compare = [&](size_t i, const Lookup& lookup) {
    answers.clear();
    for (const Entry& entry : lookup.alike) {
      Tally& t = tally[entry.slot];
      if (t.answered == i + 1) continue;
      const Descriptor& other = slots_[entry.slot].descriptors[entry.feature];
      if (HammingDistance(descriptors[i], other) > kMaxDistance) continue;
      t.answered = i + 1;
      answers.push_back(entry.slot);
    }
    const double weight =
        std::log((num_keyframes + 1) / static_cast<double>(std::max<size_t>(answers.size(), 1)));
    total += weight;
    for (const uint32_t slot : answers) {
      tally[slot].weight += weight;
      ++tally[slot].matches;
    }
  };

  std::vector<Pairing> pairings(slots_.size());
  std::array<Lookup, 4> lookups;  // of four features in a row, each one step behind the next
  const size_t n = descriptors.size();
  for (size_t i = 0; i < n + 3; ++i) {
    if (i < n) FetchBuckets(descriptors[i], lookups[i % 4]);
    if (i >= 1 && i - 1 < n) FetchEntries(lookups[(i - 1) % 4]);
    if (i >= 2 && i - 2 < n) {
      FetchDescriptors(static_cast<uint32_t>(i - 2), lookups[(i - 2) % 4], pairings);
    }
    if (i >= 3) compare(i - 3, lookups[(i - 3) % 4]);
  }

  std::vector<PlaceScore> out;
  for (const auto& [id, slot] : blocks_) {
    if (tally[slot].matches > 0) {
      out.push_back({id, tally[slot].weight / total, tally[slot].matches});
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  return out;
}

}  // namespace gw::backend

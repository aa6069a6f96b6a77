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

// Every step of a feature's way through the index (the buckets, their entries, the descriptors of
// those that are told apart no further) lies elsewhere in a memory much larger than the caches: a
// step asks for what the next one reads, and another one is done meanwhile.
struct PlaceIndex::Lookup {
  std::array<uint16_t, kTables> groups;
};

// What the slots said to the features of the query so far.
struct PlaceIndex::Answers {
  std::vector<size_t> newest;   // by slot: 1 + the newest feature that it answered
  std::vector<uint32_t> slots;  // that answered this feature
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

void PlaceIndex::FetchDescriptors(const Lookup& lookup, int table, size_t query,
                                  const Answers& answers, std::vector<Entry>& alike) const {
  const std::vector<Entry>& bucket = Bucket(table, lookup.groups[table]);
  const uint16_t sketch = SketchFor(lookup.groups, table);
  // No processor foretells which ones pass: a branch would cost more than writing them all.
  alike.resize(bucket.size());
  size_t passed = 0;
  for (const Entry& entry : bucket) {
    alike[passed] = entry;
    passed += __builtin_popcount(entry.sketch ^ sketch) <= kMaxSketchDistance ? 1 : 0;
  }
  size_t kept = 0;
  for (size_t i = 0; i < passed; ++i) {
    const Entry entry = alike[i];
    if (answers.newest[entry.slot] == query + 1) continue;
    alike[kept++] = entry;
    __builtin_prefetch(slots_[entry.slot].descriptors.data() + entry.feature);
  }
  alike.resize(kept);
}

void PlaceIndex::Compare(const Descriptor& descriptor, size_t query,
                         const std::vector<Entry>& alike, Answers& answers) const {
  for (const Entry& entry : alike) {
    if (answers.newest[entry.slot] == query + 1) continue;
    const Descriptor& other = slots_[entry.slot].descriptors[entry.feature];
    if (HammingDistance(descriptor, other) > kMaxDistance) continue;
    answers.newest[entry.slot] = query + 1;
    answers.slots.push_back(entry.slot);
  }
}

// Most slots answer in one of the first tables: what the others hold of them need not be compared.
void PlaceIndex::Ask(const Descriptor& descriptor, size_t query, const Lookup& lookup,
                     std::array<std::vector<Entry>, 2>& alike, Answers& answers) const {
  answers.slots.clear();
  for (int table = 0; table < kTables; ++table) {
    FetchDescriptors(lookup, table, query, answers, alike[table % 2]);
    if (table > 0) Compare(descriptor, query, alike[(table + 1) % 2], answers);
  }
  Compare(descriptor, query, alike[(kTables + 1) % 2], answers);
}

std::vector<PlaceScore> PlaceIndex::Query(const std::vector<Descriptor>& descriptors) const {
  struct Tally {
    double weight = 0;
    int matches = 0;
  };
  std::vector<Tally> tally(slots_.size());
  Answers answers{std::vector<size_t>(slots_.size()), {}};
  std::array<std::vector<Entry>, 2> alike;
  const double num_keyframes = static_cast<double>(blocks_.size());
  double total = 0;
  std::array<Lookup, 3> lookups;  // of three features in a row, each one step behind the next
  const size_t n = descriptors.size();
  for (size_t i = 0; i < n + 2; ++i) {
    if (i < n) FetchBuckets(descriptors[i], lookups[i % 3]);
    if (i >= 1 && i - 1 < n) FetchEntries(lookups[(i - 1) % 3]);
    if (i < 2) continue;
    Ask(descriptors[i - 2], i - 2, lookups[(i - 2) % 3], alike, answers);
    const auto num_answers = static_cast<double>(std::max<size_t>(answers.slots.size(), 1));
    const double weight = std::log((num_keyframes + 1) / num_answers);
    total += weight;
    for (const uint32_t slot : answers.slots) {
      tally[slot].weight += weight;
      ++tally[slot].matches;
    }
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

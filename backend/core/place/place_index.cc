#include "backend/core/place/place_index.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/core/check.h"

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

void PlaceIndex::Insert(std::span<const Place> places) {
  std::array<std::vector<Filed>, kTables> filed;
  for (const Place& place : places) {
    Erase(place.keyframe);
    if (free_slots_.empty()) {
      free_slots_.push_back(static_cast<uint32_t>(slots_.size()));
      slots_.emplace_back();
      erased_.push_back(0);
    }
    const uint32_t slot = free_slots_.back();
    free_slots_.pop_back();
    blocks_[place.keyframe] = slot;
    slots_[slot] = {place.keyframe, place.descriptors};
    for (size_t i = 0; i < place.descriptors.size(); ++i) {
      const auto groups = Groups(place.descriptors[i]);
      for (int t = 0; t < kTables; ++t) {
        filed[t].push_back({groups[t], {slot, static_cast<uint16_t>(i), SketchFor(groups, t)}});
      }
    }
  }
  num_recent_ += places.size();
  // With the root of all, merging what is recent and merging it into the rest cost the same.
  const bool settle = num_recent_ * num_recent_ > slots_.size();
  for (int t = 0; t < kTables; ++t) {
    std::vector<Filed>& recent = tables_[t].recent;
    const auto middle = static_cast<ptrdiff_t>(recent.size());
    recent.insert(recent.end(), filed[t].begin(), filed[t].end());
    if (settle) continue;
    const auto by_key = [](const Filed& a, const Filed& b) { return a.key < b.key; };
    std::sort(recent.begin() + middle, recent.end(), by_key);
    std::inplace_merge(recent.begin(), recent.begin() + middle, recent.end(), by_key);
  }
  if (settle) Settle();
}

void PlaceIndex::Erase(KeyframeId id) {
  const auto it = blocks_.find(id);
  if (it == blocks_.end()) return;
  slots_[it->second] = {};
  erased_[it->second] = 1;
  blocks_.erase(it);
  ++num_erased_;
  if (4 * num_erased_ > slots_.size()) Settle();
}

void PlaceIndex::Settle() {
  for (Table& table : tables_) SettleTable(table);
  for (size_t slot = 0; slot < slots_.size(); ++slot) {
    if (erased_[slot] != 0) free_slots_.push_back(static_cast<uint32_t>(slot));
    erased_[slot] = 0;
  }
  num_recent_ = 0;
  num_erased_ = 0;
}

// Counting sort: the old entries of a key, then the recent ones, without those of erased places.
void PlaceIndex::SettleTable(Table& table) {
  constexpr size_t kKeys = size_t{1} << kBits;
  const std::vector<uint32_t> old_begin =
      table.begin.empty() ? std::vector<uint32_t>(kKeys + 1) : std::move(table.begin);
  const auto stays = [this](const Entry& entry) { return erased_[entry.slot] == 0; };
  std::vector<uint32_t> begin(kKeys + 1);
  for (size_t key = 0; key < kKeys; ++key) {
    for (uint32_t i = old_begin[key]; i < old_begin[key + 1]; ++i) {
      begin[key + 1] += stays(table.entries[i]) ? 1 : 0;
    }
  }
  for (const Filed& f : table.recent) begin[f.key + size_t{1}] += stays(f.entry) ? 1 : 0;
  for (size_t key = 0; key < kKeys; ++key) begin[key + 1] += begin[key];
  std::vector<Entry> entries(begin[kKeys]);
  std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
  for (size_t key = 0; key < kKeys; ++key) {
    for (uint32_t i = old_begin[key]; i < old_begin[key + 1]; ++i) {
      if (stays(table.entries[i])) entries[next[key]++] = table.entries[i];
    }
  }
  for (const Filed& f : table.recent) {
    if (stays(f.entry)) entries[next[f.key]++] = f.entry;
  }
  table = {std::move(begin), std::move(entries), {}};
}

// Which slots have answered which features of a query. Erased slots are taken for such that have.
class PlaceIndex::Answers {
 public:
  Answers(size_t num_features, const std::vector<uint8_t>& erased)
      : words_((erased.size() + 63) / 64), erased_(words_), bits_(num_features * words_) {
    for (size_t slot = 0; slot < erased.size(); ++slot) {
      if (erased[slot] != 0) erased_[slot / 64] |= uint64_t{1} << (slot % 64);
    }
    for (size_t i = 0; i < num_features; ++i) {
      std::copy(erased_.begin(), erased_.end(), RowOf(i));
    }
  }
  uint64_t* RowOf(size_t feature) { return bits_.data() + feature * words_; }
  static bool Has(const uint64_t* row, uint32_t slot) { return row[slot / 64] >> (slot % 64) & 1; }
  static void Set(uint64_t* row, uint32_t slot) { row[slot / 64] |= uint64_t{1} << (slot % 64); }

  // The slots that answered, in ascending order.
  void Collect(size_t feature, std::vector<uint32_t>& slots) {
    slots.clear();
    for (size_t w = 0; w < words_; ++w) {
      for (uint64_t rest = RowOf(feature)[w] & ~erased_[w]; rest != 0; rest &= rest - 1) {
        slots.push_back(static_cast<uint32_t>(64 * w) +
                        static_cast<uint32_t>(std::countr_zero(rest)));
      }
    }
  }

 private:
  size_t words_;
  std::vector<uint64_t> erased_;
  std::vector<uint64_t> bits_;  // words_ per feature
};

// A feature of the query on its way through one table.
class PlaceIndex::Question {
 public:
  void Start(const Descriptor& descriptor, uint16_t sketch, uint64_t* answers) {
    descriptor_ = &descriptor;
    sketch_ = sketch;
    answers_ = answers;
    size_ = 0;
  }
  // Takes up the entries that resemble the feature, but for those of slots that have answered it,
  // and asks memory for their descriptors.
  template <typename EntryOf>
  void Gather(size_t begin, size_t end, const EntryOf& entry_of, const std::vector<Block>& slots) {
    if (alike_.size() < size_ + end - begin + 1) alike_.resize(size_ + end - begin + 1);
    // No processor foretells which ones pass: a branch would cost more than writing them all.
    const size_t first = size_;
    for (size_t i = begin; i < end; ++i) {
      const Entry& entry = entry_of(i);
      alike_[size_] = entry;
      const bool resembles = __builtin_popcount(entry.sketch ^ sketch_) <= kMaxSketchDistance;
      size_ +=
          static_cast<size_t>(resembles) & static_cast<size_t>(!Answers::Has(answers_, entry.slot));
    }
    for (size_t i = first; i < size_; ++i) {
      __builtin_prefetch(slots[alike_[i].slot].descriptors.data() + alike_[i].feature);
    }
  }
  // Most slots answer in one of the first tables: what the others hold of them is not compared.
  void Compare(const std::vector<Block>& slots) const {
    for (size_t i = 0; i < size_; ++i) {
      const Entry& entry = alike_[i];
      if (Answers::Has(answers_, entry.slot)) continue;
      const Descriptor& other = slots[entry.slot].descriptors[entry.feature];
      if (HammingDistance(*descriptor_, other) <= kMaxDistance) Answers::Set(answers_, entry.slot);
    }
  }

 private:
  const Descriptor* descriptor_ = nullptr;
  uint16_t sketch_ = 0;
  uint64_t* answers_ = nullptr;
  size_t size_ = 0;
  std::vector<Entry> alike_;  // the first size_ of these
};

std::vector<PlaceScore> PlaceIndex::Query(const std::vector<Descriptor>& descriptors) const {
  const size_t n = descriptors.size();
  GW_CHECK(n <= kMaxFeatures);
  std::vector<std::array<uint16_t, 16>> groups;
  groups.reserve(n);
  for (const Descriptor& descriptor : descriptors) groups.push_back(Groups(descriptor));
  Answers answers(n, erased_);
  std::vector<uint32_t> order(n);  // key and feature
  std::array<Question, 2> questions;
  for (int t = 0; t < kTables; ++t) {
    const Table& table = tables_[t];
    for (size_t i = 0; i < n; ++i) {
      order[i] = static_cast<uint32_t>(groups[i][t]) << 16 | static_cast<uint32_t>(i);
    }
    std::sort(order.begin(), order.end());
    size_t recent = 0;
    for (size_t k = 0; k < n; ++k) {
      const size_t feature = order[k] & 0xFFFF;
      const uint32_t key = order[k] >> 16;
      Question& question = questions[k % 2];
      question.Start(descriptors[feature], SketchFor(groups[feature], t), answers.RowOf(feature));
      if (!table.begin.empty()) {
        question.Gather(
            table.begin[key], table.begin[key + 1],
            [&](size_t i) -> const Entry& { return table.entries[i]; }, slots_);
      }
      while (recent < table.recent.size() && table.recent[recent].key < key) ++recent;
      size_t end = recent;
      while (end < table.recent.size() && table.recent[end].key == key) ++end;
      question.Gather(
          recent, end, [&](size_t i) -> const Entry& { return table.recent[i].entry; }, slots_);
      if (k > 0) questions[(k - 1) % 2].Compare(slots_);
    }
    if (n > 0) questions[(n - 1) % 2].Compare(slots_);
  }

  struct Tally {
    double weight = 0;
    int matches = 0;
  };
  std::vector<Tally> tally(slots_.size());
  std::vector<uint32_t> answering;
  const double num_keyframes = static_cast<double>(blocks_.size());
  double total = 0;
  for (size_t i = 0; i < n; ++i) {
    answers.Collect(i, answering);
    const auto num_answers = static_cast<double>(std::max<size_t>(answering.size(), 1));
    const double weight = std::log((num_keyframes + 1) / num_answers);
    total += weight;
    for (const uint32_t slot : answering) {
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

// Values by a 64-bit id, for look-ups in inner loops: one multiplication and one or two cache
// lines, where std::unordered_map divides and follows a list.
//
// Open addressing with linear probing, at most half full; values lie in chunks and stay where they
// are until they are erased. Removal closes the gap (Knuth, "The Art of Computer Programming",
// volume 3, section 6.4, algorithm R). Copyable when T is. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace gw {

template <typename T>
class IdTable {
 public:
  IdTable() = default;
  IdTable(const IdTable& other) {
    other.ForEach([this](int64_t id, const T& value) { *Insert(id).first = value; });
  }
  IdTable(IdTable&& other) noexcept { Swap(other); }
  IdTable& operator=(IdTable other) noexcept {
    Swap(other);
    return *this;
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  // Null when there is none.
  const T* Find(int64_t id) const { return cells_.empty() ? nullptr : cells_[Seek(id)].value; }
  T* Find(int64_t id) { return cells_.empty() ? nullptr : cells_[Seek(id)].value; }
  bool Contains(int64_t id) const { return Find(id) != nullptr; }

  // The value of the id, and whether it is new (T()).
  std::pair<T*, bool> Insert(int64_t id) {
    if (2 * (size_ + 1) > cells_.size()) Grow();
    Cell& cell = cells_[Seek(id)];
    if (cell.value != nullptr) return {cell.value, false};
    cell = {id, Take()};
    ++size_;
    return {cell.value, true};
  }

  // False when there is none.
  bool Erase(int64_t id) {
    if (cells_.empty()) return false;
    size_t gap = Seek(id);
    if (cells_[gap].value == nullptr) return false;
    *cells_[gap].value = T();
    free_.push_back(cells_[gap].value);
    --size_;
    // Whoever was pushed beyond the gap, and may lie in it, moves up.
    for (size_t at = Next(gap); cells_[at].value != nullptr; at = Next(at)) {
      const size_t from_home = (at - Home(cells_[at].id)) & (cells_.size() - 1);
      const size_t from_gap = (at - gap) & (cells_.size() - 1);
      if (from_home < from_gap) continue;
      cells_[gap] = cells_[at];
      gap = at;
    }
    cells_[gap] = {};
    return true;
  }

  // visit(id, value) for all, in an order that only follows from the calls so far.
  template <typename Visit>
  void ForEach(Visit&& visit) const {
    for (const Cell& cell : cells_) {
      if (cell.value != nullptr) visit(cell.id, std::as_const(*cell.value));
    }
  }

 private:
  struct Cell {
    int64_t id = 0;
    T* value = nullptr;  // null: the cell is free
  };
  static constexpr size_t kChunk = 256;
  static constexpr int kFirstBits = 10;

  void Swap(IdTable& other) noexcept {
    cells_.swap(other.cells_);
    chunks_.swap(other.chunks_);
    free_.swap(other.free_);
    std::swap(size_, other.size_);
    std::swap(bits_, other.bits_);
  }

  // Multiplicative hashing with the golden ratio (Knuth, volume 3, section 6.4).
  size_t Home(int64_t id) const {
    return (static_cast<uint64_t>(id) * 0x9E3779B97F4A7C15U) >> (64 - bits_);
  }
  size_t Next(size_t at) const { return (at + 1) & (cells_.size() - 1); }
  // The cell of the id, or the free one where it belongs.
  size_t Seek(int64_t id) const {
    size_t at = Home(id);
    while (cells_[at].value != nullptr && cells_[at].id != id) at = Next(at);
    return at;
  }

  void Grow() {
    std::vector<Cell> old;
    old.swap(cells_);
    bits_ = old.empty() ? kFirstBits : bits_ + 1;
    cells_.resize(size_t{1} << bits_);
    for (const Cell& cell : old) {
      if (cell.value != nullptr) cells_[Seek(cell.id)] = cell;
    }
  }

  T* Take() {
    if (free_.empty()) {
      chunks_.push_back(std::make_unique<T[]>(kChunk));
      for (size_t i = kChunk; i-- > 0;) free_.push_back(&chunks_.back()[i]);
    }
    T* value = free_.back();
    free_.pop_back();
    return value;
  }

  std::vector<Cell> cells_;  // their number is a power of two, or zero
  std::vector<std::unique_ptr<T[]>> chunks_;
  std::vector<T*> free_;
  size_t size_ = 0;
  int bits_ = 0;
};

}  // namespace gw

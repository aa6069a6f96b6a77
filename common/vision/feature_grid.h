// The features of one image in square cells, so that a search looks only near the pixel it asks
// for.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/contract/map.h"

namespace gw {

class FeatureGrid {
 public:
  FeatureGrid() = default;
  // Covers the bounding box of the features; keeps no reference to them, indices refer to them.
  // Precondition: all u, v are finite and within [-kMaxPixel, kMaxPixel].
  explicit FeatureGrid(const std::vector<Feature>& features);

  static constexpr float kMaxPixel = 16384;

  // Calls visit(index) for every feature inside the square of half width `radius` (px) around
  // (u, v), in a fixed order. Coordinates that are not finite find nothing.
  template <typename Visit>
  void ForEachNear(float u, float v, float radius, Visit&& visit) const {
    if (columns_ == 0 || !std::isfinite(u) || !std::isfinite(v)) return;
    const int x0 = Cell(u - radius - u0_, columns_);
    const int x1 = Cell(u + radius - u0_, columns_);
    const int y0 = Cell(v - radius - v0_, rows_);
    const int y1 = Cell(v + radius - v0_, rows_);
    for (int y = y0; y <= y1; ++y) {
      const int begin = start_[y * columns_ + x0];
      const int end = start_[y * columns_ + x1 + 1];
      for (int k = begin; k < end; ++k) {
        const Entry& e = entries_[k];
        if (std::abs(e.u - u) <= radius && std::abs(e.v - v) <= radius) visit(e.index);
      }
    }
  }

 private:
  static constexpr float kCell = 16;  // px
  struct Entry {
    float u, v;
    int index;
  };
  // The cell of an offset from the corner; outside: the nearest.
  static int Cell(float offset, int count) {
    const float cell = std::floor(offset / kCell);
    if (cell < 0) return 0;
    return cell >= static_cast<float>(count) ? count - 1 : static_cast<int>(cell);
  }

  float u0_ = 0, v0_ = 0;  // corner of the first cell
  int columns_ = 0, rows_ = 0;
  std::vector<int32_t> start_;  // of each cell in entries_; one more at the end
  std::vector<Entry> entries_;  // by cell; features keep their order inside one
};

}  // namespace gw

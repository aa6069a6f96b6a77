// The features of one image, sorted into square cells for fast look-up around a pixel.
#pragma once

#include <vector>

#include "common/contract/map.h"

namespace gw::frontend {

class FeatureGrid {
 public:
  // Keeps no reference to `features`; indices refer to it.
  void Build(const std::vector<Feature>& features, int width, int height);

  // Calls visit(index) for every feature within `radius` (square) of (u, v), in a fixed order.
  template <typename Visit>
  void ForEachNear(float u, float v, float radius, Visit&& visit) const {
    const int x0 = Clamp(static_cast<int>((u - radius) / kCell), columns_);
    const int x1 = Clamp(static_cast<int>((u + radius) / kCell), columns_);
    const int y0 = Clamp(static_cast<int>((v - radius) / kCell), rows_);
    const int y1 = Clamp(static_cast<int>((v + radius) / kCell), rows_);
    for (int y = y0; y <= y1; ++y) {
      const int begin = start_[y * columns_ + x0];
      const int end = start_[y * columns_ + x1 + 1];
      for (int k = begin; k < end; ++k) {
        const Entry& e = entries_[k];
        if (e.u - u > radius || u - e.u > radius || e.v - v > radius || v - e.v > radius) continue;
        visit(e.index);
      }
    }
  }

 private:
  static constexpr float kCell = 16;  // px
  struct Entry {
    float u, v;
    int index;
  };
  static int Clamp(int x, int n) { return x < 0 ? 0 : x >= n ? n - 1 : x; }

  int columns_ = 1, rows_ = 1;
  std::vector<int> start_ = {0, 0};
  std::vector<Entry> entries_;
};

}  // namespace gw::frontend

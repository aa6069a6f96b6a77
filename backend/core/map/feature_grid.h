// Features of one image in square cells, so that a search looks only near the pixel it asks for.
#pragma once

#include <cstdint>
#include <vector>

#include "common/contract/map.h"

namespace gw::backend {

class FeatureGrid {
 public:
  FeatureGrid() = default;
  // Covers the bounding box of the features. Precondition: all u, v are finite and within
  // [-kMaxPixel, kMaxPixel].
  explicit FeatureGrid(const std::vector<Feature>& features);

  static constexpr float kMaxPixel = 16384;

  // Appends to `out` the indices of the features whose cell touches the square of half width
  // `radius` (px) around (u, v): a superset of those inside, in a fixed order. Coordinates that are
  // not finite find nothing.
  void Near(double u, double v, double radius, std::vector<int>& out) const;

 private:
  static constexpr float kCell = 24;  // px; about one feature per cell at 800 in 640x480

  float u0_ = 0, v0_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<int32_t> start_;  // of each cell in items_; one more at the end
  std::vector<int32_t> items_;
};

}  // namespace gw::backend

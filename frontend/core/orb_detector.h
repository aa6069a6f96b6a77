// FAST corners of one pyramid level: first with the high contrast threshold, then with the low one
// in those cells of a grid that got too few.
#pragma once

#include <memory>
#include <vector>

#include "frontend/core/image_buffer.h"

namespace gw::frontend {

struct Corner {
  int16_t x = 0, y = 0;  // px of the level
  int16_t score = 0;     // FAST score: the largest threshold at which it still is a corner
};

class OrbDetector {
 public:
  // Corners keep `border` px away from the image's edge. Preconditions: 4 <= border, low <= high.
  OrbDetector(int threshold, int threshold_low, int border);
  ~OrbDetector();
  OrbDetector(OrbDetector&&) noexcept;
  OrbDetector& operator=(OrbDetector&&) noexcept;

  // Local maxima of the score (3x3), in a fixed order. Replaces the content of `corners`.
  void Detect(const ImageBuffer& level, std::vector<Corner>* corners);

 private:
  struct Scratch;
  int threshold_, threshold_low_, border_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace gw::frontend

// FAST corners of one pyramid level (FAST-9, Rosten and Drummond 2006): those above the high
// contrast threshold, and in cells of a grid that have too few of them those above the low one.
#pragma once

#include <cstdint>
#include <vector>

#include "frontend/core/features/image_buffer.h"

namespace gw::frontend {

struct Corner {
  int16_t x = 0, y = 0;  // px of the level
  int16_t score = 0;     // see FastScore
};

// Contrast of a corner: the largest t such that nine neighbouring pixels of the circle of radius 3
// are all brighter, or all darker, than the centre by at least t. At most 255, at least 0.
// Precondition: (x, y) is at least 3 px from every border.
int FastScore(const ImageBuffer& image, int x, int y);

// Where a corner lies, relative to its pixel (px).
struct CornerOffset {
  float dx = 0, dy = 0;
};

// Mean of the 5x5 pixels around a corner, weighted by the cube of their FAST scores. On TUM fr1_rpy
// this brings the reprojection sigma from 0.59 to 0.40 px of the level; a parabola through the
// scores gives 0.43, a gradient-based (Foerstner) step nothing.
// Precondition: (x, y) is at least 5 px from every border.
CornerOffset RefineCorner(const ImageBuffer& image, int x, int y);

// Ratio of the smaller to the larger eigenvalue of the structure tensor in the 7 x 7 pixels around
// (x, y): 0 on a straight edge, 1 where gradients go all ways alike. What lies on an edge slides
// along it and says nothing about motion in that direction. 0 where there is no gradient at all.
// Precondition: 4 pixels of image on all sides.
double CornerRatio(const ImageBuffer& image, int x, int y);

class OrbDetector {
 public:
  // Corners keep `border` px away from the image's edge. Preconditions: 4 <= border, 0 < low <=
  // high < 255.
  OrbDetector(int threshold, int threshold_low, int border);

  // Corners whose score is above the threshold and not below that of any of the eight neighbours
  // (of equal ones the first counts), row by row, left to right. Replaces the content of `corners`.
  void Detect(const ImageBuffer& level, std::vector<Corner>* corners);

 private:
  int threshold_, threshold_low_, border_;
  std::vector<uint8_t> scores_;  // of three rows, in turn
  std::vector<int16_t> peaks_;   // of one row
  std::vector<int> count_;       // strong corners per cell
};

}  // namespace gw::frontend

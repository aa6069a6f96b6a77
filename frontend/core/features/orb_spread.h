// Picks corners that are strong and spread over the image: a quadtree is refined until it has as
// many leaves as corners are wanted, and each leaf keeps its strongest corner.
#pragma once

#include <array>
#include <vector>

#include "frontend/core/features/orb_detector.h"

namespace gw::frontend {

class OrbSpread {
 public:
  // Keeps at most `wanted` of `corners`, in a fixed order that depends on the content alone.
  // Reorders `corners`. `width`, `height`: size of the level (px).
  void Select(int width, int height, int wanted, std::vector<Corner>* corners,
              std::vector<Corner>* selected);

 private:
  struct Node {
    int x0, y0, x1, y1;  // half-open box (px)
    int begin, end;      // its corners
  };
  // Sorts the corners from begin to end by the quarters about (xm, ym): left above, right above,
  // left below, right below. Returns where each begins, and the end.
  std::array<int, 5> SplitInFour(int begin, int end, int xm, int ym, std::vector<Corner>* corners);

  std::vector<Node> nodes_, next_;
  std::vector<Corner> split_;
  std::vector<int> order_;
};

}  // namespace gw::frontend

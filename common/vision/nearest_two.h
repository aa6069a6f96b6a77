// The two of many points whose descriptors are nearest to one: for matching without a prediction,
// where the distance to the second tells whether the first is unmistakable.
#pragma once

#include <cstddef>
#include <vector>

#include "common/contract/map.h"

namespace gw {

struct NearestTwo {
  size_t index = 0;  // of the nearest point; of two that are equally near, the first
  int best = 257;    // Hamming distances; 257, more than there can be, where there is no such point
  int second = 257;
};

// Point: anything with a `descriptor`.
template <typename Point>
NearestTwo FindNearestTwo(const Descriptor& descriptor, const std::vector<const Point*>& points) {
  NearestTwo out;
  for (size_t i = 0; i < points.size(); ++i) {
    const int d = HammingDistance(descriptor, points[i]->descriptor);
    if (d < out.best) {
      out.second = out.best;
      out.best = d;
      out.index = i;
    } else if (d < out.second) {
      out.second = d;
    }
  }
  return out;
}

}  // namespace gw

// The circle of radius 3 of FAST.
#pragma once

#include <cstddef>

namespace gw::frontend {

struct CirclePoint {
  int x, y;
};
// In order.
inline constexpr CirclePoint kFastCircle[16] = {
    {0, -3}, {1, -3}, {2, -2}, {3, -1}, {3, 0},  {3, 1},   {2, 2},   {1, 3},
    {0, 3},  {-1, 3}, {-2, 2}, {-3, 1}, {-3, 0}, {-3, -1}, {-2, -2}, {-1, -3}};

}  // namespace gw::frontend

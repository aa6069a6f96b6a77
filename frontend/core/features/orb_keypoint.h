// A corner as the detector finds it, before undistortion and depth.
#pragma once

#include <cstdint>

namespace gw::frontend {

struct OrbKeypoint {
  float u = 0, v = 0;  // px of level 0 of the image it was found in; pixel centres are integers
  float x = 0, y = 0;  // px of its own level
  float angle = 0;     // rad, from +u towards +v, in (-pi, pi]
  float score = 0;     // corner contrast, grey levels
  uint8_t level = 0;
};

}  // namespace gw::frontend

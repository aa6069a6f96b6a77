// The 256 binary tests of the descriptor: bit i is 1 when the smoothed patch is darker at point a_i
// than at point b_i. Rotated BRIEF (Rublee et al., ORB, ICCV 2011); the pattern is our own.
#pragma once

#include <array>
#include <cstdint>

namespace gw::frontend {

// All points of the pattern, also rotated and rounded, lie within this distance (px) of the centre
// on either axis; it is also the radius of the disc that gives the orientation.
inline constexpr int kOrbPatchRadius = 15;

struct OrbTest {
  int8_t ax, ay, bx, by;  // px
};

using OrbPattern = std::array<OrbTest, 256>;

// Points drawn from N(0, (31 / 5)^2 px^2), the best of the samplings that the BRIEF paper (Calonder
// et al., ECCV 2010) compares, cut to the disc.
OrbPattern MakeGaussianOrbPattern(uint64_t seed);

}  // namespace gw::frontend

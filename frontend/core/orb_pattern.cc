#include "frontend/core/orb_pattern.h"

#include <cmath>
#include <utility>

#include "common/core/random.h"

namespace gw::frontend {

OrbPattern MakeGaussianOrbPattern(uint64_t seed) {
  constexpr double kSigma = 31.0 / 5.0;
  // Rotation keeps the length, rounding adds up to half a pixel per axis.
  constexpr double kMaxRadius = kOrbPatchRadius - 0.5;
  CounterRng rng(seed, 0, 0);
  const auto draw = [&rng]() {
    for (;;) {
      const int x = static_cast<int>(std::lround(kSigma * rng.Normal()));
      const int y = static_cast<int>(std::lround(kSigma * rng.Normal()));
      if (std::hypot(x, y) <= kMaxRadius) return std::pair{x, y};
    }
  };
  OrbPattern pattern;
  for (OrbTest& test : pattern) {
    const auto a = draw();
    auto b = draw();
    while (b == a) b = draw();
    test = {static_cast<int8_t>(a.first), static_cast<int8_t>(a.second),
            static_cast<int8_t>(b.first), static_cast<int8_t>(b.second)};
  }
  return pattern;
}

}  // namespace gw::frontend

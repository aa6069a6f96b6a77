// Noise that is a smooth function of a coordinate (a way, a place), the same whenever it is asked.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/core/random.h"

namespace gw::sim {

class SmoothNoise {
 public:
  // Mean 0, sigma about 1; values further apart than `length` are independent.
  SmoothNoise(uint64_t seed, uint64_t stream, double length)
      : seed_(seed), stream_(stream), length_(length) {}

  double At(double s) const {
    const double x = s / length_;
    const double cell = std::floor(x);
    const double f = x - cell;
    // C2, so that what it drives has a continuous acceleration.
    const double t = f * f * f * (f * (f * 6 - 15) + 10);
    const double a = Lattice(static_cast<int64_t>(cell));
    const double b = Lattice(static_cast<int64_t>(cell) + 1);
    return (a + t * (b - a)) * kNorm;
  }

 private:
  static constexpr double kNorm = 1.18;  // the mean over f of (1-t)^2 + t^2 is 0.72
  double Lattice(int64_t i) const {
    return CounterRng(seed_, stream_, static_cast<uint64_t>(i)).Normal();
  }
  uint64_t seed_, stream_;
  double length_;
};

}  // namespace gw::sim

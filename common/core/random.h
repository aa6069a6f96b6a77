// Random numbers that depend only on (seed, stream, index), never on how many were drawn before:
// a dropped frame does not shift later draws, and the same input gives the same bytes everywhere.
// Generator: SplitMix64 (Steele, Lea, Flood 2014) over a mixed counter.
#pragma once

#include <cmath>
#include <cstdint>

namespace gw {

class CounterRng {
 public:
  // seed: of the run; stream: of the component; index: of the frame or event.
  CounterRng(uint64_t seed, uint64_t stream, uint64_t index)
      : state_(Mix(seed + kGolden) ^ Mix(stream * 0xD1342543DE82EF95ull + 1) ^
               Mix(index * 0xAF251AF3B0F025B5ull + 2)) {}

  uint64_t NextU64() {
    state_ += kGolden;
    return Mix(state_);
  }
  // Uniform in [0, 1).
  double Uniform() { return static_cast<double>(NextU64() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // Uniform integer in [0, n). Precondition: n > 0. Bias below 2^-32 for n < 2^32.
  uint32_t Below(uint32_t n) {
    return static_cast<uint32_t>((static_cast<uint64_t>(NextU64() >> 32) * n) >> 32);
  }
  // Standard normal (Box-Muller, one of the pair).
  double Normal() {
    const double u = 1.0 - Uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * Uniform());
  }

 private:
  static constexpr uint64_t kGolden = 0x9E3779B97F4A7C15ull;
  static uint64_t Mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  uint64_t state_;
};

}  // namespace gw

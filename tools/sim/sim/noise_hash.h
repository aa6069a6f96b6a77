// Fast noise for every pixel: a hash of the pixel, not a generator with a state, so that rows can
// be made in any order, and simple enough for vector instructions.
#pragma once

#include <cstdint>

namespace gw::sim {

// Finaliser of MurmurHash3 (A. Appleby, public domain).
inline uint32_t HashPixel(uint32_t pixel, uint32_t key) {
  uint32_t h = pixel * 0x9E3779B1u + key;
  h ^= h >> 16;
  h *= 0x85EBCA6Bu;
  h ^= h >> 13;
  h *= 0xC2B2AE35u;
  h ^= h >> 16;
  return h;
}

// Mean 0, variance 1, nearly normal (sum of four uniform bytes), bounded by +-3.45.
inline float UnitNoise(uint32_t hash) {
  const uint32_t sum = (hash & 255u) + ((hash >> 8) & 255u) + ((hash >> 16) & 255u) + (hash >> 24);
  return (static_cast<float>(static_cast<int32_t>(sum)) - 510.0f) * (1.0f / 147.80167f);
}

}  // namespace gw::sim

// FNV-1a, 64 bit: names a configuration or a file in messages and reports. Not cryptographic.
#pragma once

#include <cstdint>
#include <string_view>

namespace gw {

constexpr uint64_t kFnvOffset = 0xCBF29CE484222325ull;

constexpr uint64_t Fnv1a(std::string_view bytes, uint64_t hash = kFnvOffset) {
  for (const char c : bytes) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001B3ull;
  }
  return hash;
}

}  // namespace gw

// Reads and writes little-endian numbers in rows of bytes.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace gw {

// Readers have the precondition at + size <= bytes.size().
inline uint16_t ReadU16(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint16_t>(bytes[at] | bytes[at + 1] << 8);
}
inline int16_t ReadI16(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<int16_t>(ReadU16(bytes, at));
}
inline uint32_t ReadU32(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint32_t>(ReadU16(bytes, at)) | static_cast<uint32_t>(ReadU16(bytes, at + 2))
                                                         << 16;
}
inline int32_t ReadI32(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<int32_t>(ReadU32(bytes, at));
}
inline uint64_t ReadU64(std::span<const uint8_t> bytes, size_t at) {
  return ReadU32(bytes, at) | static_cast<uint64_t>(ReadU32(bytes, at + 4)) << 32;
}
inline float ReadF32(std::span<const uint8_t> bytes, size_t at) {
  return std::bit_cast<float>(ReadU32(bytes, at));
}

inline void AppendU16(uint16_t value, std::vector<uint8_t>* out) {
  out->push_back(static_cast<uint8_t>(value & 0xFF));
  out->push_back(static_cast<uint8_t>(value >> 8));
}
inline void AppendI16(int16_t value, std::vector<uint8_t>* out) {
  AppendU16(static_cast<uint16_t>(value), out);
}
inline void AppendU32(uint32_t value, std::vector<uint8_t>* out) {
  AppendU16(static_cast<uint16_t>(value & 0xFFFF), out);
  AppendU16(static_cast<uint16_t>(value >> 16), out);
}
inline void AppendU64(uint64_t value, std::vector<uint8_t>* out) {
  AppendU32(static_cast<uint32_t>(value & 0xFFFFFFFF), out);
  AppendU32(static_cast<uint32_t>(value >> 32), out);
}
inline void AppendF32(float value, std::vector<uint8_t>* out) {
  AppendU32(std::bit_cast<uint32_t>(value), out);
}

}  // namespace gw

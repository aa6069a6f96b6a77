// Little-endian integers in byte rows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gw::kobuki {

// Precondition of the readers: at + size <= bytes.size().
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

}  // namespace gw::kobuki

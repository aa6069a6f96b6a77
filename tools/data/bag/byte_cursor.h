// Little-endian numbers and strings out of bytes that may end anywhere.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

namespace gw::bag {

using Bytes = std::span<const uint8_t>;

// Reads past the end give zero or nothing and clear ok(), for good.
class ByteCursor {
 public:
  explicit ByteCursor(Bytes bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  size_t position() const { return position_; }
  size_t left() const { return bytes_.size() - position_; }

  template <typename T>
  T Read() {
    T value{};
    const Bytes bytes = Take(sizeof(T));
    if (ok_) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  Bytes Take(uint64_t count) {
    if (!ok_ || count > left()) {
      ok_ = false;
      return {};
    }
    const Bytes bytes = bytes_.subspan(position_, count);
    position_ += count;
    return bytes;
  }
  // With a 32-bit length in front.
  Bytes Block() { return Take(Read<uint32_t>()); }
  std::string Text() {
    const Bytes bytes = Block();
    return {bytes.begin(), bytes.end()};
  }

 private:
  Bytes bytes_;
  size_t position_ = 0;
  bool ok_ = true;
};

inline std::string_view TextOf(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace gw::bag

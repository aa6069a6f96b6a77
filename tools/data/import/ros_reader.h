// Fields of a ROS message out of its bytes.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "common/core/se3.h"
#include "common/core/time.h"
#include "tools/data/bag/bag.h"

namespace gw::importer {

static_assert(std::endian::native == std::endian::little, "ROS and depth pixels are little-endian");

struct RosMessage {
  bag::Bytes bytes;
  bag::Serialization serialization = bag::Serialization::kRos1;
};

// Reads past the end give zero and clear ok(). ROS 1: fields in order, little-endian, arrays and
// strings with a 32-bit length in front. CDR (OMG, "Common Data Representation", XCDR version 1, of
// plain structures): the same, each number aligned to its size after the 4 bytes of encapsulation,
// whose second bit tells the byte order; strings end with a zero that counts.
class RosReader {
 public:
  explicit RosReader(const RosMessage& message)
      : bytes_(message.bytes), cdr_(message.serialization == bag::Serialization::kCdr) {
    if (message.serialization == bag::Serialization::kOther) ok_ = false;
    if (!cdr_) return;
    const bag::Bytes head = Take(4);
    // Only plain CDR; parameter lists and version 2 are laid out otherwise.
    if (ok_ && (head[0] != 0 || head[1] > 1)) ok_ = false;
    swap_ = ok_ && head[1] == 0;
  }
  bool ok() const { return ok_; }
  bool cdr() const { return cdr_; }
  void Fail() { ok_ = false; }

  template <typename T>
  T Read() {
    Align(sizeof(T));
    const bag::Bytes bytes = Take(sizeof(T));
    uint8_t raw[sizeof(T)] = {};
    if (ok_) std::memcpy(raw, bytes.data(), sizeof(T));
    if (swap_) {
      for (size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
    }
    T value{};
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }
  // An array of bytes.
  bag::Bytes Array() { return Take(Read<uint32_t>()); }
  std::string Text() {
    bag::Bytes bytes = Array();
    if (cdr_ && !bytes.empty()) bytes = bytes.first(bytes.size() - 1);
    return {bytes.begin(), bytes.end()};
  }
  // A frame's name, without a slash in front.
  std::string Frame() {
    std::string name = Text();
    return name.starts_with('/') ? name.substr(1) : name;
  }
  struct Header {
    int64_t ns = 0;  // since 1970; 0: not stamped
    std::string frame;
    Utime utime() const { return {(ns + 500) / 1000}; }
  };
  Header ReadHeader() {
    if (!cdr_) Read<uint32_t>();  // seq: numbered by the sender, not needed
    const int64_t seconds = cdr_ ? Read<int32_t>() : int64_t{Read<uint32_t>()};
    Header header;
    header.ns = seconds * 1'000'000'000 + Read<uint32_t>();
    header.frame = Frame();
    return header;
  }
  Eigen::Vector3d Vector() {
    const auto x = Read<double>();
    const auto y = Read<double>();
    return {x, y, Read<double>()};
  }
  // p, then q as x y z w. Fails on what is no pose.
  SE3 Pose() {
    const Eigen::Vector3d p = Vector();
    const Eigen::Vector3d xyz = Vector();
    const Eigen::Quaterniond q(Read<double>(), xyz.x(), xyz.y(), xyz.z());
    if (!(std::abs(q.norm() - 1) < 0.05) || !p.allFinite()) ok_ = false;
    return ok_ ? SE3(q, p) : SE3();
  }
  void SkipReals(size_t count) {
    Align(sizeof(double));
    Take(count * sizeof(double));
  }

 private:
  void Align(size_t size) {
    if (cdr_) Take((size - (position_ - 4) % size) % size);
  }
  bag::Bytes Take(uint64_t count) {
    if (!ok_ || count > bytes_.size() - position_) {
      ok_ = false;
      return {};
    }
    const bag::Bytes bytes = bytes_.subspan(position_, count);
    position_ += count;
    return bytes;
  }

  bag::Bytes bytes_;
  size_t position_ = 0;
  bool cdr_;
  bool swap_ = false;
  bool ok_ = true;
};

}  // namespace gw::importer

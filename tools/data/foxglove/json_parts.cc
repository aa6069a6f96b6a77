#include "tools/data/foxglove/json_parts.h"

#include <algorithm>
#include <bit>

#include "tools/data/files/json.h"

namespace gw::foxglove {

Json JsonTime(Utime utime) {
  const int64_t us = std::max<int64_t>(utime.us, 0);
  return {{"sec", us / 1'000'000}, {"nsec", us % 1'000'000 * 1000}};
}

Json JsonVector(const Eigen::Vector3d& v) {
  return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
}

Json JsonPose(const SE3& T) {
  const Eigen::Quaterniond& q = T.rotation();
  return {{"position", JsonVector(T.translation())},
          {"orientation", {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}}};
}

Json JsonColor(const Color& color) {
  return {{"r", color.r}, {"g", color.g}, {"b", color.b}, {"a", color.a}};
}

std::string Base64(std::span<const uint8_t> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t have = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < have ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) {
      text.push_back(k <= have ? kDigits[group >> (18 - 6 * k) & 63] : '=');
    }
  }
  return text;
}

void PackedElements::AddFloat(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  for (int shift = 0; shift < 32; shift += 8) {
    bytes_.push_back(static_cast<uint8_t>(bits >> shift));
  }
}

Json PackedField(const std::string& name, int offset, int type) {
  return {{"name", name}, {"offset", offset}, {"type", type}};
}

}  // namespace gw::foxglove

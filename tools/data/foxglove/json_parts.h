// The pieces that Foxglove's messages are made of, as JSON.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/se3.h"
#include "common/core/time.h"
#include "tools/data/files/json_fwd.h"

namespace gw::foxglove {

using tools::Json;

// {sec, nsec}. Times before 1970 do not exist in Foxglove's schemas; they become 0.
Json JsonTime(Utime utime);
Json JsonVector(const Eigen::Vector3d& v);
Json JsonPose(const SE3& T);

struct Color {
  double r = 0, g = 0, b = 0, a = 1;  // 0 to 1
};
Json JsonColor(const Color& color);

// Binary fields of JSON messages: base64 with padding (RFC 4648, section 4).
std::string Base64(std::span<const uint8_t> bytes);

// An array of packed little-endian elements, for PointCloud and Grid.
class PackedElements {
 public:
  void AddFloat(float value);
  void AddByte(uint8_t value) { bytes_.push_back(value); }
  std::string base64() const { return Base64(bytes_); }

 private:
  std::vector<uint8_t> bytes_;
};

// foxglove.PackedElementField: `type` of foxglove.NumericType.
inline constexpr int kUint8 = 1;
inline constexpr int kFloat32 = 7;
Json PackedField(const std::string& name, int offset, int type);

}  // namespace gw::foxglove

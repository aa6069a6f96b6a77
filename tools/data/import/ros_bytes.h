// ROS 1 messages as bytes, for tests.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace gw::importer {

class RosWriter {
 public:
  template <typename T>
  RosWriter& Add(T value) {
    const auto* begin = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof(T));
    return *this;
  }
  RosWriter& Text(const std::string& text) {
    Add(static_cast<uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  RosWriter& Header(uint32_t seconds, uint32_t nanoseconds, const std::string& frame = "f") {
    return Add(uint32_t{7}).Add(seconds).Add(nanoseconds).Text(frame);
  }
  RosWriter& Reals(const std::vector<double>& values) {
    for (const double value : values) Add(value);
    return *this;
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
};

inline std::vector<uint8_t> RosImage(uint32_t seconds, uint32_t nanoseconds, uint32_t width,
                                     uint32_t height, const std::string& encoding, uint32_t step,
                                     const std::vector<uint8_t>& data) {
  RosWriter w;
  w.Header(seconds, nanoseconds).Add(height).Add(width).Text(encoding).Add(uint8_t{0}).Add(step);
  w.Add(static_cast<uint32_t>(data.size()));
  for (const uint8_t byte : data) w.Add(byte);
  return w.bytes();
}

inline std::vector<uint8_t> RosImu(uint32_t seconds, uint32_t nanoseconds,
                                   const std::vector<double>& gyro,
                                   const std::vector<double>& accel) {
  const std::vector<double> covariance(9);
  RosWriter w;
  w.Header(seconds, nanoseconds).Reals({0, 0, 0, 1}).Reals(covariance);
  w.Reals(gyro).Reals(covariance).Reals(accel).Reals(covariance);
  return w.bytes();
}

inline std::vector<uint8_t> RosOdometry(uint32_t seconds, uint32_t nanoseconds,
                                        const std::vector<double>& xyz_qxyzw) {
  RosWriter w;
  w.Header(seconds, nanoseconds, "odom").Text("base_link").Reals(xyz_qxyzw);
  w.Reals(std::vector<double>(36 + 6 + 36));
  return w.bytes();
}

inline std::vector<uint8_t> RosTransform1(uint32_t seconds, uint32_t nanoseconds,
                                          const std::string& parent, const std::string& child,
                                          const std::vector<double>& xyz_qxyzw) {
  RosWriter w;
  w.Add(uint32_t{1}).Header(seconds, nanoseconds, parent).Text(child).Reals(xyz_qxyzw);
  return w.bytes();
}

}  // namespace gw::importer

// Small ROS 1 bags for tests: one connection a topic, messages in a single chunk, no index.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tools/data/import/ros_bytes.h"

namespace gw::importer {

class TestBag {
 public:
  // Received one millisecond after the message before, from 100 s on.
  void Add(const std::string& topic, const std::string& type, const std::vector<uint8_t>& message) {
    if (!connections_.contains(topic)) {
      const auto id = static_cast<uint32_t>(connections_.size());
      connections_[topic] = id;
      AddRecord({Field("op", uint8_t{7}), Field("conn", id), TextField("topic", topic)},
                Joined({TextField("topic", topic), TextField("type", type)}), chunk_);
    }
    received_ns_ += 1'000'000;
    const uint64_t time = 100 | (received_ns_ << 32);
    AddRecord({Field("op", uint8_t{2}), Field("conn", connections_[topic]), Field("time", time)},
              message, chunk_);
  }

  void Write(const std::filesystem::path& file) const {
    const std::string magic = "#ROSBAG V2.0\n";
    std::vector<uint8_t> bytes(magic.begin(), magic.end());
    AddRecord({Field("op", uint8_t{3}), Field("index_pos", uint64_t{0})}, {}, bytes);
    AddRecord({Field("op", uint8_t{5}), TextField("compression", "none"),
               Field("size", static_cast<uint32_t>(chunk_.size()))},
              chunk_, bytes);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<int64_t>(bytes.size()));
  }

 private:
  using Bytes = std::vector<uint8_t>;

  template <typename T>
  static Bytes Field(const std::string& name, T value) {
    RosWriter content;
    for (const char c : name + "=") content.Add(c);
    return content.Add(value).bytes();
  }
  static Bytes TextField(const std::string& name, const std::string& value) {
    const std::string content = name + "=" + value;
    return {content.begin(), content.end()};
  }
  static Bytes Joined(const std::vector<Bytes>& fields) {
    RosWriter out;
    for (const Bytes& field : fields) {
      out.Add(static_cast<uint32_t>(field.size()));
      for (const uint8_t byte : field) out.Add(byte);
    }
    return out.bytes();
  }
  static void AddRecord(const std::vector<Bytes>& fields, const Bytes& data, Bytes& out) {
    const Bytes header = Joined(fields);
    for (const Bytes* part : {&header, &data}) {
      const Bytes size = RosWriter().Add(static_cast<uint32_t>(part->size())).bytes();
      out.insert(out.end(), size.begin(), size.end());
      out.insert(out.end(), part->begin(), part->end());
    }
  }

  std::map<std::string, uint32_t> connections_;
  Bytes chunk_;
  uint64_t received_ns_ = 0;
};

// A CameraInfo, of 64 x 64 pixels where nothing else is said.
struct RosInfo {
  std::string model = "plumb_bob";
  std::vector<double> D = std::vector<double>(5);
  double focal_px = 60;
  double baseline_m = 0;  // of a right eye
  uint32_t width = 64, height = 64;
  double centre_px = 31.5;

  std::vector<uint8_t> Bytes(uint32_t tenth) const {
    RosWriter w;
    w.Header(100, tenth * 100000000, "camera").Add(height).Add(width).Text(model);
    w.Add(static_cast<uint32_t>(D.size())).Reals(D);
    const double f = focal_px, c = centre_px;
    w.Reals({f, 0, c, 0, f, c, 0, 0, 1}).Reals({1, 0, 0, 0, 1, 0, 0, 0, 1});
    w.Reals({f, 0, c, -f * baseline_m, 0, f, c, 0, 0, 0, 1, 0});
    for (int i = 0; i < 2 + 4; ++i) w.Add(uint32_t{0});
    return w.Add(uint8_t{0}).bytes();
  }
};

}  // namespace gw::importer

// Bags written by the rosbag library itself, read back by the importer.
#include "tools/data/import/rosbag.h"

#include <gmock/gmock.h>
#include <rosbag/bag.h>

#include "common/config/writer.h"
#include "tools/data/import/ros_bytes.h"
#include "tools/data/import/test_folder.h"

namespace gw::importer {

// A message of any type as bytes, which rosbag::Bag::write accepts through the traits below.
struct RawMessage {
  std::string type;
  std::vector<uint8_t> bytes;
};

}  // namespace gw::importer

namespace ros::message_traits {
template <>
struct MD5Sum<gw::importer::RawMessage> {
  static const char* value(const gw::importer::RawMessage&) {
    return "0123456789abcdef0123456789abcdef";
  }
};
template <>
struct DataType<gw::importer::RawMessage> {
  static const char* value(const gw::importer::RawMessage& m) { return m.type.c_str(); }
};
template <>
struct Definition<gw::importer::RawMessage> {
  static const char* value(const gw::importer::RawMessage&) { return "not stated"; }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<gw::importer::RawMessage> {
  template <typename Stream>
  static void write(Stream& stream, const gw::importer::RawMessage& m) {
    std::memcpy(stream.advance(static_cast<uint32_t>(m.bytes.size())), m.bytes.data(),
                m.bytes.size());
  }
  static uint32_t serializedLength(const gw::importer::RawMessage& m) {
    return static_cast<uint32_t>(m.bytes.size());
  }
};
}  // namespace ros::serialization

namespace gw::importer {
namespace {

using testing::HasSubstr;

// Three frames of 80 x 64 at 10 Hz from 100 s, IMU, odometry, and ground truth among other
// transforms.
void WriteBag(const TestFolder& folder, rosbag::CompressionType compression,
              const std::string& image_type = "sensor_msgs/Image") {
  rosbag::Bag bag;
  bag.open((folder.path() / "r.bag").string(), rosbag::bagmode::Write);
  bag.setCompression(compression);
  for (uint32_t i = 0; i < 3; ++i) {
    const uint32_t ns = i * 100000000;
    const ros::Time time(100, ns);
    const auto write = [&](const char* topic, const std::string& type, std::vector<uint8_t> bytes) {
      bag.write(topic, time, RawMessage{type, std::move(bytes)});
    };
    const std::vector<uint8_t> color(80 * 64 * 3, static_cast<uint8_t>(10 + i));
    RosWriter metres;
    for (int k = 0; k < 80 * 64; ++k) metres.Add(1.5F + 0.001F * static_cast<float>(i));
    write("/camera/color/image_raw", image_type, RosImage(100, ns, 80, 64, "rgb8", 240, color));
    write("/camera/aligned_depth_to_color/image_raw", "sensor_msgs/Image",
          RosImage(100, ns + 1000000, 80, 64, "32FC1", 320, metres.bytes()));
    write("/camera/imu", "sensor_msgs/Imu", RosImu(100, ns, {0, 0, 0.5}, {0, 0, 9.8}));
    write("/odom", "nav_msgs/Odometry", RosOdometry(100, ns, {0.1 * i, 0, 0, 0, 0, 0, 1}));
    write("/tf", "tf2_msgs/TFMessage",
          RosTransform1(100, ns, "odom", "base_link", {9, 9, 9, 0, 0, 0, 1}));
    write("/tf", "tf2_msgs/TFMessage",
          RosTransform1(100, ns, "world", "base_link_gt", {0.1 * i, 2, 0, 0, 0, 0, 1}));
  }
  bag.close();
  RobotConfig config;
  config.robot.name = "r";
  config.calibration.camera.width = 80;
  config.calibration.camera.height = 64;
  config.calibration.camera.left = {60, 60, 40, 32, {}};
  folder.Write("robot.yaml", WriteRobotConfig(config));
}

RosbagOptions Options(const TestFolder& folder) {
  RosbagOptions options;
  options.robot_config = folder.path() / "robot.yaml";
  return options;
}

TEST(Rosbag, ReadsEveryStreamWithEachCompression) {
  for (const auto compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    const TestFolder folder;
    WriteBag(folder, compression);
    const auto recording = ReadRosbag(folder.path() / "r.bag", Options(folder));
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_EQ(recording->frames->size(), 3u);
    EXPECT_EQ(recording->frames->utime(1).us, 100100000);
    const auto pixels = recording->frames->Load(2);
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_EQ(pixels->left.bytes[0], 12);
    EXPECT_EQ(reinterpret_cast<const uint16_t*>(pixels->depth.bytes.data())[5], 1502);
    ASSERT_EQ(recording->imu.size(), 3u);
    EXPECT_EQ(recording->imu[1].w_I_rad_s.z(), 0.5);
    ASSERT_EQ(recording->wheel.size(), 2u);
    EXPECT_NEAR(recording->wheel[0].dx_m, 0.1, 1e-12);
    ASSERT_EQ(recording->ground_truth.size(), 3u);
    EXPECT_NEAR(recording->ground_truth[2].T_GB.translation().y(), 2, 1e-12);
    EXPECT_NEAR(recording->calibration.camera.rate_hz, 10, 1e-9);
  }
}

TEST(Rosbag, BadBagsAndOptionsAreRefused) {
  const TestFolder folder;
  WriteBag(folder, rosbag::compression::Uncompressed);
  const auto error = [&](const RosbagOptions& options) {
    const auto recording = ReadRosbag(folder.path() / "r.bag", options);
    return recording ? std::string("no error") : recording.error().message;
  };
  EXPECT_THAT(error({}), HasSubstr("--calibration ROBOT.yaml"));
  RosbagOptions options = Options(folder);
  options.depth = "/no/such";
  EXPECT_THAT(error(options), HasSubstr("--depth"));
  options = Options(folder);
  options.imu = "/odom";
  EXPECT_THAT(error(options), HasSubstr("holds nav_msgs/Odometry, expected sensor_msgs/Imu"));
  folder.Write("r.bag", "no bag");
  EXPECT_THAT(error(Options(folder)), HasSubstr("cannot be read as a bag"));
  folder.Remove("r.bag");
  EXPECT_THAT(error(Options(folder)), HasSubstr("not there"));
  WriteBag(folder, rosbag::compression::BZ2);
  std::filesystem::resize_file(folder.path() / "r.bag", 3000);
  EXPECT_THAT(error(Options(folder)), HasSubstr("r.bag"));
}

}  // namespace
}  // namespace gw::importer

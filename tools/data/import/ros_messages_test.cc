#include "tools/data/import/ros_messages.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "common/core/random.h"
#include "tools/data/import/image_file.h"
#include "tools/data/import/ros_bytes.h"
#include "tools/data/import/ros_images.h"

namespace gw::importer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Result<Image> Grey(const std::vector<uint8_t>& bytes) {
  return DecodeRosGrey({bytes}, "sensor_msgs/Image");
}
Result<Image> Depth(const std::vector<uint8_t>& bytes) {
  return DecodeRosDepth({bytes}, "sensor_msgs/Image", 0.001);
}

TEST(RosMessages, ImagesOfEachEncodingWithPaddedRows) {
  const auto mono = Grey(RosImage(1, 2499, 2, 2, "mono8", 3, {1, 2, 99, 3, 4, 99}));
  ASSERT_TRUE(mono) << mono.error().message;
  EXPECT_THAT(mono->bytes, ElementsAre(1, 2, 3, 4));
  EXPECT_FALSE(mono->converted);
  const auto rgb = Grey(RosImage(1, 0, 1, 1, "rgb8", 3, {200, 20, 10}));
  const auto bgr = Grey(RosImage(1, 0, 1, 1, "bgr8", 3, {10, 20, 200}));
  ASSERT_TRUE(rgb && bgr);
  EXPECT_EQ(rgb->bytes, bgr->bytes);
  EXPECT_EQ(rgb->bytes[0], GreyOf(200, 20, 10));
  for (const auto& [encoding, pixel] :
       {std::pair{"rgba8", std::vector<uint8_t>{200, 20, 10, 7}}, {"bgra8", {10, 20, 200, 7}}}) {
    const auto image = Grey(RosImage(1, 0, 1, 1, encoding, 4, pixel));
    ASSERT_TRUE(image) << encoding;
    EXPECT_EQ(image->bytes, rgb->bytes) << encoding;
  }
  const auto wide = Grey(RosImage(1, 0, 2, 1, "mono16", 4, {9, 1, 8, 2}));
  ASSERT_TRUE(wide);
  EXPECT_THAT(wide->bytes, ElementsAre(1, 2));
  const auto luma = Grey(RosImage(1, 0, 2, 1, "yuv422_yuy2", 4, {1, 100, 2, 100}));
  ASSERT_TRUE(luma);
  EXPECT_THAT(luma->bytes, ElementsAre(1, 2));
  const auto plain = Grey(RosImage(1, 0, 2, 1, "8UC1", 2, {5, 6}));
  ASSERT_TRUE(plain);
  EXPECT_FALSE(plain->converted);
  const auto depth = Depth(RosImage(1, 0, 2, 1, "16UC1", 4, {1, 2, 3, 4}));
  ASSERT_TRUE(depth);
  EXPECT_THAT(depth->bytes, ElementsAre(1, 2, 3, 4));
}

TEST(RosMessages, DepthInMetresIsRoundedAndWhatIsNoDepthBecomesZero) {
  RosWriter pixels;
  for (const float metres : {1.2344F, 0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), 70.0F,
                             std::numeric_limits<float>::infinity()}) {
    pixels.Add(metres);
  }
  const auto depth = Depth(RosImage(1, 0, 6, 1, "32FC1", 24, pixels.bytes()));
  ASSERT_TRUE(depth);
  const auto* values = reinterpret_cast<const uint16_t*>(depth->bytes.data());
  EXPECT_EQ(values[0], 1234);
  for (int i = 1; i < 6; ++i) EXPECT_EQ(values[i], 0) << i;
}

TEST(RosMessages, ImuOdometryAndTransforms) {
  const auto imu = DecodeRosImu({RosImu(100, 500499600, {1, 2, 3}, {4, 5, 6})});
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->utime.us, 100500500);
  EXPECT_EQ(imu->w_I_rad_s, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(imu->a_I_m_s2, Eigen::Vector3d(4, 5, 6));
  const double h = std::sqrt(0.5);
  const auto odometry =
      DecodeRosPose({RosOdometry(1, 0, {1, 2, 3, 0, 0, h, h})}, "nav_msgs/Odometry");
  ASSERT_TRUE(odometry);
  EXPECT_NEAR(LogSO3(odometry->T.rotation()).z(), M_PI / 2, 1e-9);
  EXPECT_EQ(odometry->T.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(odometry->child, "base_link");
  const auto tf =
      DecodeRosTransforms({RosTransform1(1, 0, "/world", "body", {1, 2, 3, 0, 0, h, h})});
  ASSERT_TRUE(tf);
  ASSERT_EQ(tf->size(), 1u);
  EXPECT_EQ(tf->front().parent, "world");
  EXPECT_EQ(tf->front().child, "body");
}

TEST(RosMessages, RefusesWhatIsNoSuchMessage) {
  EXPECT_FALSE(Grey(RosImage(1, 0, 2, 2, "mono8", 2, {1, 2, 3})));
  EXPECT_FALSE(Grey(RosImage(1, 0, 2, 2, "mono8", 1, {1, 2, 3, 4})));
  EXPECT_FALSE(Grey(RosImage(1, 0, 0, 2, "mono8", 0, {})));
  EXPECT_FALSE(Grey(RosImage(1, 0, 100000, 100000, "mono8", 100000, {1})));
  const auto encoding = Grey(RosImage(1, 0, 1, 1, "nv12", 2, {1, 2}));
  ASSERT_FALSE(encoding);
  EXPECT_THAT(encoding.error().message, HasSubstr("'nv12'"));
  EXPECT_FALSE(DecodeRosImu({RosImu(1, 0, {NAN, 0, 0}, {0, 0, 0})}));
  EXPECT_FALSE(DecodeRosPose({RosOdometry(1, 0, {0, 0, 0, 0, 0, 0, 0})}, "nav_msgs/Odometry"));
}

// A Bayer image of one colour shows that colour, whatever the pattern begins with.
TEST(RosMessages, BayerPatternsAreToldApart) {
  for (const auto& [encoding, red_x, red_y] : {std::tuple{"bayer_rggb8", 0, 0},
                                               {"bayer_grbg8", 1, 0},
                                               {"bayer_gbrg8", 0, 1},
                                               {"bayer_bggr8", 1, 1}}) {
    std::vector<uint8_t> pixels(16 * 16, 0);
    for (int y = red_y; y < 16; y += 2) {
      for (int x = red_x; x < 16; x += 2) pixels[static_cast<size_t>(16 * y + x)] = 200;
    }
    const auto image = Grey(RosImage(1, 0, 16, 16, encoding, 16, pixels));
    ASSERT_TRUE(image) << encoding;
    EXPECT_EQ(image->bytes[8 * 16 + 8], GreyOf(200, 0, 0)) << encoding;
  }
}

std::vector<uint8_t> Compressed(const std::string& format, const std::vector<uint8_t>& data) {
  RosWriter w;
  w.Header(1, 0).Text(format).Add(static_cast<uint32_t>(data.size()));
  for (const uint8_t byte : data) w.Add(byte);
  return w.bytes();
}

TEST(RosMessages, CompressedImagesAndDepth) {
  std::vector<uint8_t> jpeg, png;
  ASSERT_TRUE(cv::imencode(".jpg", cv::Mat(16, 16, CV_8UC3, cv::Scalar(90, 90, 90)), jpeg));
  const auto grey = DecodeRosGrey({Compressed("bgr8; jpeg compressed bgr8", jpeg)},
                                  "sensor_msgs/CompressedImage");
  ASSERT_TRUE(grey) << grey.error().message;
  EXPECT_NEAR(grey->bytes[100], 90, 1);
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(4, 4, CV_16UC1, cv::Scalar(1234)), png));
  RosWriter head;
  head.Add(int32_t{0}).Add(1000.F).Add(34.F);
  std::vector<uint8_t> data = head.bytes();
  data.insert(data.end(), png.begin(), png.end());
  const auto units = [&](const std::string& format) {
    const auto depth =
        DecodeRosDepth({Compressed(format, data)}, "sensor_msgs/CompressedImage", 0.001);
    return depth ? int{reinterpret_cast<const uint16_t*>(depth->bytes.data())[3]} : -1;
  };
  EXPECT_EQ(units("16UC1; compressedDepth png"), 1234);
  EXPECT_EQ(units("32FC1; compressedDepth png"), 833);  // 1000 / (1234 - 34) m
  EXPECT_EQ(units("16UC1; compressedDepth rvl"), -1);
  EXPECT_EQ(units("png"), -1);
}

// Whatever the bytes are, they are decoded or refused.
TEST(RosMessages, TruncatedAndRandomBytesAreRefusedQuietly) {
  const auto image = RosImage(1, 0, 4, 4, "mono8", 4, std::vector<uint8_t>(16, 5));
  for (size_t size = 0; size < image.size(); ++size) {
    ASSERT_FALSE(DecodeRosGrey({bag::Bytes(image).first(size)}, "sensor_msgs/Image")) << size;
  }
  const auto tf = RosTransform1(1, 0, "world", "body", {1, 2, 3, 0, 0, 0, 1});
  for (size_t size = 0; size < tf.size(); ++size) {
    ASSERT_FALSE(DecodeRosTransforms({bag::Bytes(tf).first(size)})) << size;
  }
  for (uint64_t i = 0; i < 2000; ++i) {
    CounterRng rng(1, 2, i);
    std::vector<uint8_t> bytes(rng.Below(200));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.Below(256) >> rng.Below(8));
    for (const auto serialization : {bag::Serialization::kRos1, bag::Serialization::kCdr}) {
      if (serialization == bag::Serialization::kCdr && bytes.size() > 1) bytes[0] = bytes[1] = 0;
      const RosMessage message{bytes, serialization};
      for (const char* type : {"sensor_msgs/Image", "sensor_msgs/CompressedImage"}) {
        (void)DecodeRosGrey(message, type).ok();
        (void)DecodeRosDepth(message, type, 0.001).ok();
        (void)DecodeRosEncoding(message, type).ok();
      }
      (void)DecodeRosImu(message).ok();
      (void)DecodeRosPose(message, "nav_msgs/Odometry").ok();
      (void)DecodeRosTransforms(message).ok();
      (void)DecodeRosCameraInfo(message).ok();
      (void)DecodeRosJoints(message).ok();
      (void)DecodeKobukiTicks(message).ok();
    }
  }
}

}  // namespace
}  // namespace gw::importer

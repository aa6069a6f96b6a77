#include "tools/data/import/ros_messages.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "common/core/random.h"
#include "tools/data/import/image_file.h"
#include "tools/data/import/ros_bytes.h"

namespace gw::importer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(RosMessages, ImagesOfEachEncodingWithPaddedRows) {
  const auto mono = DecodeRosGrey(RosImage(1, 2499, 2, 2, "mono8", 3, {1, 2, 99, 3, 4, 99}));
  ASSERT_TRUE(mono) << mono.error().message;
  EXPECT_THAT(mono->bytes, ElementsAre(1, 2, 3, 4));
  EXPECT_FALSE(mono->converted);
  const auto rgb = DecodeRosGrey(RosImage(1, 0, 1, 1, "rgb8", 3, {200, 20, 10}));
  const auto bgr = DecodeRosGrey(RosImage(1, 0, 1, 1, "bgr8", 3, {10, 20, 200}));
  ASSERT_TRUE(rgb && bgr);
  EXPECT_EQ(rgb->bytes, bgr->bytes);
  EXPECT_EQ(rgb->bytes[0], GreyOf(200, 20, 10));
  const auto depth = DecodeRosDepth(RosImage(1, 0, 2, 1, "16UC1", 4, {1, 2, 3, 4}), 0.001);
  ASSERT_TRUE(depth);
  EXPECT_THAT(depth->bytes, ElementsAre(1, 2, 3, 4));
}

TEST(RosMessages, DepthInMetresIsRoundedAndWhatIsNoDepthBecomesZero) {
  RosWriter pixels;
  for (const float metres : {1.2344F, 0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), 70.0F,
                             std::numeric_limits<float>::infinity()}) {
    pixels.Add(metres);
  }
  const auto depth = DecodeRosDepth(RosImage(1, 0, 6, 1, "32FC1", 24, pixels.bytes()), 0.001);
  ASSERT_TRUE(depth);
  const auto* values = reinterpret_cast<const uint16_t*>(depth->bytes.data());
  EXPECT_EQ(values[0], 1234);
  for (int i = 1; i < 6; ++i) EXPECT_EQ(values[i], 0) << i;
}

TEST(RosMessages, ImuOdometryAndTransforms) {
  const auto imu = DecodeRosImu(RosImu(100, 500499600, {1, 2, 3}, {4, 5, 6}));
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->utime.us, 100500500);
  EXPECT_EQ(imu->w_I_rad_s, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(imu->a_I_m_s2, Eigen::Vector3d(4, 5, 6));
  const double h = std::sqrt(0.5);
  const auto odometry = DecodeRosOdometry(RosOdometry(1, 0, {1, 2, 3, 0, 0, h, h}));
  ASSERT_TRUE(odometry);
  EXPECT_NEAR(LogSO3(odometry->T.rotation()).z(), M_PI / 2, 1e-9);
  EXPECT_EQ(odometry->T.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(odometry->child, "base_link");
  const auto tf = DecodeRosTransforms(RosTransform1(1, 0, "/world", "body", {1, 2, 3, 0, 0, h, h}));
  ASSERT_TRUE(tf);
  ASSERT_EQ(tf->size(), 1u);
  EXPECT_EQ(tf->front().parent, "world");
  EXPECT_EQ(tf->front().child, "body");
}

TEST(RosMessages, RefusesWhatIsNoSuchMessage) {
  EXPECT_FALSE(DecodeRosGrey(RosImage(1, 0, 2, 2, "mono8", 2, {1, 2, 3})));
  EXPECT_FALSE(DecodeRosGrey(RosImage(1, 0, 2, 2, "mono8", 1, {1, 2, 3, 4})));
  EXPECT_FALSE(DecodeRosGrey(RosImage(1, 0, 0, 2, "mono8", 0, {})));
  EXPECT_FALSE(DecodeRosGrey(RosImage(1, 0, 100000, 100000, "mono8", 100000, {1})));
  const auto encoding = DecodeRosGrey(RosImage(1, 0, 1, 1, "yuv422", 2, {1, 2}));
  ASSERT_FALSE(encoding);
  EXPECT_THAT(encoding.error().message, HasSubstr("'yuv422'"));
  EXPECT_FALSE(DecodeRosImu(RosImu(1, 0, {NAN, 0, 0}, {0, 0, 0})));
  EXPECT_FALSE(DecodeRosOdometry(RosOdometry(1, 0, {0, 0, 0, 0, 0, 0, 0})));
}

// Whatever the bytes are, they are decoded or refused.
TEST(RosMessages, TruncatedAndRandomBytesAreRefusedQuietly) {
  const auto image = RosImage(1, 0, 4, 4, "mono8", 4, std::vector<uint8_t>(16, 5));
  for (size_t size = 0; size < image.size(); ++size) {
    ASSERT_FALSE(DecodeRosGrey(RosBytes(image).first(size))) << size;
  }
  const auto tf = RosTransform1(1, 0, "world", "body", {1, 2, 3, 0, 0, 0, 1});
  for (size_t size = 0; size < tf.size(); ++size) {
    ASSERT_FALSE(DecodeRosTransforms(RosBytes(tf).first(size))) << size;
  }
  for (uint64_t i = 0; i < 2000; ++i) {
    CounterRng rng(1, 2, i);
    std::vector<uint8_t> bytes(rng.Below(200));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.Below(256) >> rng.Below(8));
    (void)DecodeRosGrey(bytes).ok();
    (void)DecodeRosDepth(bytes, 0.001).ok();
    (void)DecodeRosImu(bytes).ok();
    (void)DecodeRosOdometry(bytes).ok();
    (void)DecodeRosTransforms(bytes).ok();
  }
}

}  // namespace
}  // namespace gw::importer

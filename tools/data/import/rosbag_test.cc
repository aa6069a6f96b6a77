// Bags as robots record them, imported: bag/testing/make_bags.py tells what is in them, and
// test_bag.h writes others.
#include "tools/data/import/rosbag.h"

#include <gmock/gmock.h>

#include "common/config/writer.h"
#include "tools/data/import/ros_bytes.h"
#include "tools/data/import/test_bag.h"
#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kBags =
    std::filesystem::path(GW_SOURCE_DIR) / "tools/data/bag/testing/bags";

std::string ErrorOf(const Result<Recording>& recording) {
  return recording ? "no error; warnings:\n" + AllText(recording->warnings)
                   : recording.error().message;
}

TEST(Rosbag, EveryContainerGivesTheSameRecording) {
  for (const char* name :
       {"ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag", "none.mcap", "zstd.mcap", "lz4.mcap",
        "unchunked.mcap", "unindexed.mcap", "rosbag2"}) {
    SCOPED_TRACE(name);
    const auto recording = ReadRosbag(kBags / name, {});
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_TRUE(recording->warnings.empty()) << AllText(recording->warnings);
    ASSERT_EQ(recording->frames->size(), 3u);
    EXPECT_EQ(recording->frames->utime(1).us, 100'100'000);
    const auto pixels = recording->frames->Load(2);
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_EQ(pixels->left.bytes[10], 12);
    EXPECT_EQ(reinterpret_cast<const uint16_t*>(pixels->depth.bytes.data())[5], 1502);
    ASSERT_EQ(recording->imu.size(), 3u);
    EXPECT_EQ(recording->imu[1].w_I_rad_s.z(), 0.5);
    EXPECT_EQ(recording->imu[1].a_I_m_s2.z(), 9.8);
    ASSERT_EQ(recording->wheel.size(), 2u);
    EXPECT_NEAR(recording->wheel[0].dx_m, 0.1, 1e-12);
    ASSERT_EQ(recording->ground_truth.size(), 3u);
    EXPECT_NEAR(recording->ground_truth[2].T_GB.translation().y(), 2, 1e-12);
    const Calibration& calibration = recording->calibration;
    EXPECT_EQ(calibration.camera.left.fy, 61);
    EXPECT_EQ(calibration.camera.left.radtan[3], 0.002);
    EXPECT_NEAR(calibration.camera.rate_hz, 10, 1e-9);
    // The wheels' frame, base_link, is 0.1 m above the floor: the floor's is the body.
    ExpectPose(calibration.camera.T_BC,
               SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.2, 0, 0.4}));
    ExpectPose(calibration.imu.T_BI, SE3(Eigen::Quaterniond::Identity(), {0, 0, 0.15}));
  }
}

TEST(Rosbag, TopicsThatAreWishedFor) {
  RosbagOptions options;
  options.topics.imu = "none";
  options.topics.odometry = "none";
  const auto without = ReadRosbag(kBags / "none.mcap", options);
  ASSERT_TRUE(without);
  EXPECT_TRUE(without->imu.empty() && without->wheel.empty());
  options = {};
  options.topics.imu = "/gyro";
  EXPECT_THAT(ErrorOf(ReadRosbag(kBags / "none.mcap", options)),
              HasSubstr("topic /gyro (--imu) is not in the bag; those of its type are: /imu"));
  options.topics.imu = "odom";
  EXPECT_THAT(ErrorOf(ReadRosbag(kBags / "none.mcap", options)),
              HasSubstr("topic /odom (--imu) holds nav_msgs/Odometry, expected sensor_msgs/Imu"));
  options = {};
  options.topics.stereo = "/camera/image_raw";
  EXPECT_THAT(ErrorOf(ReadRosbag(kBags / "none.mcap", options)),
              HasSubstr("two topics with a comma between"));
  options.topics.stereo = "/camera/image_raw,/chatter";
  EXPECT_THAT(ErrorOf(ReadRosbag(kBags / "none.mcap", options)),
              HasSubstr("holds std_msgs/String"));
  const auto list = ListRosbag(kBags / "zstd.mcap", {});
  ASSERT_TRUE(list);
  for (const char* part : {"MCAP, 22 messages", "/chatter", "10.0 Hz", "depth: /camera/depth",
                           "tf: odom -> base_footprint (moves)"}) {
    EXPECT_THAT(*list, HasSubstr(part));
  }
}

TEST(Rosbag, ACalibrationThatIsGivenIsTakenInsteadOfTheBags) {
  const TestFolder folder;
  RobotConfig config;
  config.robot.name = "r";
  config.calibration.camera.width = 64;
  config.calibration.camera.height = 64;
  config.calibration.camera.left = {77, 77, 32, 32, {}};
  folder.Write("robot.yaml", WriteRobotConfig(config));
  RosbagOptions options;
  options.robot_config = folder.path() / "robot.yaml";
  const auto recording = ReadRosbag(kBags / "ros1_lz4.bag", options);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->calibration.camera.left.fx, 77);
  options.cid_sims_calibration = "also";
  EXPECT_THAT(ErrorOf(ReadRosbag(kBags / "ros1_lz4.bag", options)), HasSubstr("not both"));
}

// What a recording of eyes, joints and unstamped messages becomes.
TEST(Rosbag, StereoWithRationalLensesIsUndistortedOnImport) {
  const TestFolder folder;
  TestBag bag;
  for (uint32_t i = 0; i < 3; ++i) {
    for (const char* eye : {"left", "right"}) {
      RosInfo info;
      info.model = "rational_polynomial";
      info.D = {0.1, 0.01, 0, 0, 0, 0.05, 0, 0};
      info.baseline_m = eye[0] == 'r' ? 0.1 : 0;
      bag.Add(std::string("/") + eye + "/camera_info", "sensor_msgs/CameraInfo", info.Bytes(i));
      bag.Add(std::string("/") + eye + "/image_raw", "sensor_msgs/Image",
              RosImage(100, i * 100000000 + (eye[0] == 'r' ? 2000000 : 0), 64, 64, "bgr8", 192,
                       std::vector<uint8_t>(64 * 192, 90)));
    }
  }
  bag.Write(folder.path() / "r.bag");
  const auto recording = ReadRosbag(folder.path() / "r.bag", {});
  ASSERT_TRUE(recording) << recording.error().message;
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.kind, CameraKind::kStereo);
  EXPECT_FALSE(camera.left.distorted());
  ExpectPose(camera.T_C0C1, SE3(Eigen::Quaterniond::Identity(), {0.1, 0, 0}));
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->right.bytes[32 * 64 + 32], 90);
  EXPECT_EQ(pixels->right.bytes[0], 0);  // past the edge of what the lens saw
  const std::string warnings = AllText(recording->warnings);
  EXPECT_THAT(warnings, HasSubstr("up to 2.0 ms apart"));
  EXPECT_THAT(warnings, HasSubstr("tf does not tell where the frame"));
}

TEST(Rosbag, WheelsOfJointsAndTicks) {
  const TestFolder folder;
  TestBag bag;
  for (uint32_t i = 0; i < 3; ++i) {
    RosWriter joints;
    joints.Header(100, i * 100000000).Add(uint32_t{2}).Text("wheel_left_joint");
    joints.Text("wheel_right_joint").Add(uint32_t{2}).Reals({1.0 * i, 2.0 * i});
    joints.Add(uint32_t{0}).Add(uint32_t{0});
    bag.Add("/joint_states", "sensor_msgs/JointState", joints.bytes());
    RosWriter ticks;
    ticks.Header(100, i * 100000000).Add(uint16_t{0}).Add(uint8_t{0}).Add(uint8_t{0});
    ticks.Add(uint8_t{0});
    ticks.Add(static_cast<uint16_t>(65000 + 1000 * i)).Add(static_cast<uint16_t>(1000 * i));
    bag.Add("/sensors/core", "kobuki_msgs/SensorState", ticks.bytes());
  }
  bag.Write(folder.path() / "r.bag");
  RosbagOptions options;
  options.topics.odometry = "/joint_states";
  EXPECT_THAT(ErrorOf(ReadRosbag(folder.path() / "r.bag", options)), HasSubstr("--wheel-radius"));
  options.wheel_radius_m = 0.1;
  options.track_m = 0.5;
  const auto joints = ReadRosbag(folder.path() / "r.bag", options);
  ASSERT_TRUE(joints) << joints.error().message;
  ASSERT_EQ(joints->wheel.size(), 2u);
  EXPECT_NEAR(joints->wheel[1].dyaw_rad, 0.2, 1e-12);
  const auto ticks = ReadRosbag(folder.path() / "r.bag", {});
  ASSERT_TRUE(ticks);
  ASSERT_EQ(ticks->wheel.size(), 2u);
  EXPECT_NEAR(ticks->wheel[0].dx_m, 1000 / 11724.4, 1e-6);  // across the wrap
}

TEST(Rosbag, GyroAndAccelerometerOfTwoTopicsAndMessagesWithoutStamp) {
  const TestFolder folder;
  TestBag bag;
  for (uint32_t i = 0; i < 4; ++i) {
    bag.Add("/gyro/sample", "sensor_msgs/Imu",
            RosImu(100, i * 100000000 + 50000000, {0, 0, 1}, {0, 0, 0}));
    bag.Add("/accel/sample", "sensor_msgs/Imu",
            RosImu(100, i * 100000000, {0, 0, 0}, {0, 0, 9.0 + i}));
    bag.Add("/odom", "nav_msgs/Odometry", RosOdometry(0, 0, {0.1 * i, 0, 0, 0, 0, 0, 1}));
  }
  bag.Write(folder.path() / "r.bag");
  const auto recording = ReadRosbag(folder.path() / "r.bag", {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->imu.size(), 4u);
  EXPECT_NEAR(recording->imu[1].a_I_m_s2.z(), 10.5, 1e-9);
  EXPECT_FALSE(recording->imu[3].has_accel);
  EXPECT_EQ(recording->wheel.size(), 3u);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("4 messages have no stamp"));
}

TEST(Rosbag, SpoiltMessagesAreLeftOutAndCounted) {
  const TestFolder folder;
  TestBag bag;
  for (uint32_t i = 0; i < 5; ++i) {
    bag.Add("/odom", "nav_msgs/Odometry",
            RosOdometry(100, i * 100000000, {0.1 * i, 0, 0, 0, 0, 0, i == 2 ? 7.0 : 1.0}));
    bag.Add("/imu", "sensor_msgs/Imu",
            RosImu(100, i * 100000000, {0, 0, i == 3 ? NAN : 0.1}, {0, 0, 9.8}));
  }
  bag.Write(folder.path() / "r.bag");
  const auto recording = ReadRosbag(folder.path() / "r.bag", {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->wheel.size(), 3u);
  EXPECT_EQ(recording->imu.size(), 4u);
  EXPECT_THAT(AllText(recording->warnings),
              HasSubstr("topic /odom: 1 of 5 messages are of no use"));
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("topic /imu: 1 of 5 messages are of no use"));
}

TEST(Rosbag, CamerasThatAreNotCalibratedAreNamed) {
  const TestFolder folder;
  const auto error = [&](const RosInfo& info) {
    TestBag bag;
    for (const char* eye : {"left", "right"}) {
      bag.Add(std::string("/") + eye + "/camera_info", "sensor_msgs/CameraInfo", info.Bytes(0));
      bag.Add(std::string("/") + eye + "/image_raw", "sensor_msgs/Image",
              RosImage(100, 0, 64, 64, "mono8", 64, std::vector<uint8_t>(64 * 64, 90)));
    }
    bag.Write(folder.path() / "r.bag");
    return ErrorOf(ReadRosbag(folder.path() / "r.bag", {}));
  };
  EXPECT_THAT(error({}), HasSubstr("has no baseline"));
  RosInfo info;
  info.baseline_m = 0.1;
  info.model = "double_sphere";
  info.D = {0.1};
  EXPECT_THAT(error(info), HasSubstr("'double_sphere' is not known"));
  info.model = "plumb_bob";
  info.focal_px = 0;
  EXPECT_THAT(error(info), HasSubstr("is not calibrated"));
  info.focal_px = 60;
  info.width = 100;
  EXPECT_THAT(error(info), HasSubstr("another shape"));
}

TEST(Rosbag, ImagesWithoutPartnerAndBagsWithoutMessages) {
  const TestFolder folder;
  TestBag bag;
  bag.Add("/left/image_raw", "sensor_msgs/Image",
          RosImage(100, 0, 64, 64, "mono8", 64, std::vector<uint8_t>(64 * 64, 90)));
  bag.Add("/odom", "nav_msgs/Odometry", RosOdometry(100, 0, {0, 0, 0, 0, 0, 0, 1}));
  bag.Add("/odom", "nav_msgs/Odometry", RosOdometry(101, 0, {1, 0, 0, 0, 0, 0, 1}));
  bag.Write(folder.path() / "r.bag");
  const auto recording = ReadRosbag(folder.path() / "r.bag", {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->frames, nullptr);
  std::string notes;
  for (const auto& [key, text] : recording->notes) notes += text + "\n";
  EXPECT_THAT(notes, HasSubstr("choose among: /left/image_raw"));
  TestBag().Write(folder.path() / "empty.bag");
  EXPECT_THAT(ErrorOf(ReadRosbag(folder.path() / "empty.bag", {})), HasSubstr("holds no message"));
  EXPECT_THAT(ErrorOf(ReadRosbag(folder.path() / "absent.bag", {})), HasSubstr("not there"));
}

}  // namespace
}  // namespace gw::importer

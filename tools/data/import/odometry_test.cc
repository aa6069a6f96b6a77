// Wheels and IMU from text files without images, good and bad.
#include "tools/data/import/odometry.h"

#include <gmock/gmock.h>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

void WriteFolder(const TestFolder& folder) {
  folder.Write("robot/odom.txt",
               "# t x y z qx qy qz qw\n10.00 5 5 0 0 0 0 1\n10.05 5.1 5 0 0 0 0 1\n"
               "10.05 5.2 5 0 0 0 0 1\n10.10 5.3 5 0 0 0 0 1\n");
  folder.Write("robot/imu.csv", "#t,gyro,accel\n10.00,1,2,3,4,5,6\n10.01,1,2,3,4,5,6\n");
  folder.Write("robot/truth.txt", "10.02 1 2 0 0 0 0 1\n");
}

OdometryOptions WithImu(const std::filesystem::path& folder) {
  OdometryOptions options;
  options.imu = folder / "robot/imu.csv";
  return options;
}

TEST(Odometry, ReadsWheelsImuAndGroundTruth) {
  const TestFolder folder;
  WriteFolder(folder);
  OdometryOptions options = WithImu(folder.path());
  options.ground_truth = folder.path() / "robot/truth.txt";
  const auto recording = ReadOdometry(folder.path() / "robot/odom.txt", options);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->name, "robot");
  EXPECT_EQ(recording->frames, nullptr);
  EXPECT_THAT(AllText(recording->warnings),
              AllOf(HasSubstr("no images in the log"), HasSubstr("1 of 4 records repeat a time")));
  // The pose that repeats a time is left out, the way to it is not.
  ASSERT_EQ(recording->wheel.size(), 2u);
  EXPECT_NEAR(recording->wheel[0].dx_m + recording->wheel[1].dx_m, 0.3, 1e-12);
  ASSERT_EQ(recording->imu.size(), 2u);
  EXPECT_EQ(recording->imu[0].w_I_rad_s, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(recording->imu[0].a_I_m_s2, Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(recording->ground_truth.size(), 1u);
}

TEST(Odometry, ImuColumnsInEitherOrderOrGyroAlone) {
  const TestFolder folder;
  WriteFolder(folder);
  OdometryOptions options = WithImu(folder.path());
  options.imu_columns = ImuColumns::kAccelGyro;
  const auto swapped = ReadOdometry(folder.path() / "robot/odom.txt", options);
  ASSERT_TRUE(swapped);
  EXPECT_EQ(swapped->imu[0].w_I_rad_s, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(swapped->imu[0].a_I_m_s2, Eigen::Vector3d(1, 2, 3));
  folder.Write("robot/imu.csv", "10.00 1 2 3\n10.01 nan 2 3\n10.02 1 2 3\n");
  const auto gyro = ReadOdometry(folder.path() / "robot/odom.txt", WithImu(folder.path()));
  ASSERT_TRUE(gyro) << gyro.error().message;
  ASSERT_EQ(gyro->imu.size(), 2u);
  EXPECT_FALSE(gyro->imu[0].has_accel);
  EXPECT_THAT(AllText(gyro->warnings),
              HasSubstr("imu.csv:2: holds nan, null or an empty field; 1 of 3 rows"));
}

TEST(Odometry, BadFilesAreRefusedWithFileAndLine) {
  const std::vector<BadFile> cases = {
      {"robot/odom.txt", "1 2\n", {"odom.txt:1: ", "fields"}},
      {"robot/odom.txt", "1 0 0 0 0 0 0 1\n", {"odom.txt", "a single pose"}},
      {"robot/odom.txt", "1 0 0 0 0 0 0 0\n2 0 0 0 0 0 0 0\n", {"odom.txt:1: ", "0 0 0 0"}},
      {"robot/odom.txt", "1 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n", {"digits"}},
      {"robot/imu.csv", "1,2,3\n", {"imu.csv:1: "}},
      {"robot/imu.csv", "1,2,3,x\n", {"imu.csv:1: 'x'"}},
      {"robot/imu.csv", "1,nan,3,1\n", {"imu.csv:1: ", "1 of 1 rows"}},
      {"robot/imu.csv", "1.6e18,1,3,1\n", {"imu.csv:1: ", "nanoseconds"}},
  };
  ExpectRefused(cases, WriteFolder, [](const auto& path) {
    return ReadOdometry(path / "robot/odom.txt", WithImu(path));
  });
  const TestFolder folder;
  ExpectError(ReadOdometry(folder.path() / "none.txt", {}), ErrorCode::kNotFound, {"none.txt"});
}

}  // namespace
}  // namespace gw::importer

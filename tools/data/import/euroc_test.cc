// The EuRoC importer on a small folder made here, and every way in which the folder can be wrong.
#include "tools/data/import/euroc.h"

#include <gmock/gmock.h>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

std::string EurocCamera(const std::string& T_BS) {
  return "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: " + T_BS +
         "\nrate_hz: 20\nresolution: [80, 64]\ncamera_model: pinhole\n"
         "intrinsics: [458.0, 457.0, 40.0, 32.0]\ndistortion_model: radial-tangential\n"
         "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]\n";
}

void WriteEuroc(const TestFolder& folder) {
  folder.Write("mav0/cam0/sensor.yaml", EurocCamera("[0,0,1,0.1, -1,0,0,0.05, 0,-1,0,0, 0,0,0,1]"));
  folder.Write("mav0/cam1/sensor.yaml",
               EurocCamera("[0,0,1,0.1, -1,0,0,-0.05, 0,-1,0,0, 0,0,0,1]"));
  const std::string list =
      "#timestamp [ns],filename\n1403715273262142976,a.png\n1403715273312143104,b.png\r\n";
  folder.Write("mav0/cam0/data.csv", list + "1403715273362143104,c.png\n");
  folder.Write("mav0/cam1/data.csv", list);
  for (const char* name : {"a", "b"}) {
    folder.WriteGrey(std::string("mav0/cam0/data/") + name + ".png", *name);
    folder.WriteGrey(std::string("mav0/cam1/data/") + name + ".png", *name + 1);
  }
  folder.Write("mav0/imu0/sensor.yaml",
               "%YAML:1.0\nsensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n"
               "  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nrate_hz: 200\n"
               "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 1.9e-5\n"
               "accelerometer_noise_density: 2e-3\naccelerometer_random_walk: 3e-3\n");
  folder.Write("mav0/imu0/data.csv",
               "#t\n1403715273262142976,0.1,0.2,0.3,9.8,0.1,-0.2\n"
               "1403715273267142912,0.1,0.2,0.3,9.8,0.1,-0.2\n");
  folder.Write("mav0/state_groundtruth_estimate0/data.csv",
               "#t\n1403715273262142976,1,2,3,0.5,0.5,0.5,0.5,0,0,0\n");
}

TEST(Euroc, ReadsUnrectifiedStereoWithImuAndGroundTruth) {
  const TestFolder folder;
  WriteEuroc(folder);
  const auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames->size(), 2u);
  EXPECT_EQ(recording->frames->utime(0).us, 1403715273262143);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("1 images have no partner"));
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.bytes[0], 'a');
  EXPECT_EQ(pixels->right.bytes[0], 'b');
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.left.radtan[3], 1.8e-05);
  EXPECT_NEAR(camera.T_C0C1.translation().x(), 0.1, 1e-12);
  EXPECT_NEAR(camera.T_BC.translation().x(), 0.1, 1e-12);
  ASSERT_EQ(recording->imu.size(), 2u);
  EXPECT_EQ(recording->imu[0].w_I_rad_s, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(recording->imu[0].a_I_m_s2, Eigen::Vector3d(9.8, 0.1, -0.2));
  EXPECT_TRUE(recording->imu[0].has_accel);
  EXPECT_EQ(recording->calibration.imu.gyro_noise, 1.7e-4);
  ASSERT_EQ(recording->ground_truth.size(), 1u);
  ExpectPose(recording->ground_truth[0].T_GB,
             SE3(Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {1, 2, 3}));
}

// Eyes of a camera that stamps each by itself.
TEST(Euroc, EyesMillisecondsApartArePairedWithAWarning) {
  const TestFolder folder;
  WriteEuroc(folder);
  folder.Write("mav0/cam1/data.csv", "1403715273265142976,a.png\n1403715273315143104,b.png\n");
  const auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->frames->size(), 2u);
  EXPECT_EQ(recording->frames->utime(0).us, 1403715273262143);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("up to 3.0 ms apart"));
  // Half of the time between two images: no pair.
  folder.Write("mav0/cam1/data.csv", "1403715273287142976,a.png\n1403715273337143104,b.png\n");
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kBadData, {"no stamp is near"});
}

TEST(Euroc, NamesWithBlanksAndFilesFromWindowsAreRead) {
  const TestFolder folder;
  WriteEuroc(folder);
  folder.WriteGrey("mav0/cam0/data/left 1.png", 'a');
  folder.Write("mav0/cam0/data.csv",
               "\xEF\xBB\xBF#timestamp [ns],filename\r\n1403715273262142976,left 1.png\r\n"
               "1403715273312143104,\"b.png\"");
  const auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames->size(), 2u);
  for (size_t i = 0; i < 2; ++i) EXPECT_TRUE(recording->frames->Load(i)) << i;
}

TEST(Euroc, AllFaultsOfAFolderAreNamedTogether) {
  const TestFolder folder;
  WriteEuroc(folder);
  folder.Write("mav0/cam0/data.csv", "x,a.png\n");
  folder.Write("mav0/cam1/sensor.yaml", "camera_model: pinhole\n");
  folder.Write("mav0/imu0/data.csv", "1403715273262142976,1,2\n");
  folder.Write("mav0/state_groundtruth_estimate0/data.csv", "1403715273262142976,1\n");
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kBadData,
              {"cam0/data.csv:1: ", "cam1/sensor.yaml",
               "imu0/data.csv:1: ", "state_groundtruth_estimate0/data.csv:1: "});
}

// A point 45 degrees off the axis: the fisheye has it at f pi/4, the image without distortion at f.
TEST(Euroc, EquidistantLensesAreUndistorted) {
  const TestFolder folder;
  WriteEuroc(folder);
  const std::string tail =
      "camera_model: pinhole\nintrinsics: [24, 24, 40, 32]\ndistortion_model: equidistant\n"
      "distortion_coefficients: [0, 0, 0, 0]\nresolution: [80, 64]\n";
  folder.Write("mav0/cam0/sensor.yaml",
               "T_BS:\n  data: [0,0,1,0.1, -1,0,0,0.05, 0,-1,0,0, 0,0,0,1]\n" + tail);
  folder.Write("mav0/cam1/sensor.yaml",
               "T_BS:\n  data: [0,0,1,0.1, -1,0,0,-0.05, 0,-1,0,0, 0,0,0,1]\n" + tail);
  cv::Mat image(64, 80, CV_8UC1, cv::Scalar(0));
  const int x = static_cast<int>(std::lround(40 + 24 * M_PI / 4));
  image.col(x).setTo(200);
  folder.WriteImage("mav0/cam0/data/a.png", image);
  const auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels) << pixels.error().message;
  const auto row = pixels->left.bytes.begin() + 80 * 32;
  EXPECT_NEAR(std::max_element(row, row + 80) - row, 40 + 24, 1);
  EXPECT_FALSE(recording->calibration.camera.left.distorted());
  folder.Write("mav0/cam0/sensor.yaml",
               "T_BS:\n  data: [0,0,1,0.1, -1,0,0,0.05, 0,-1,0,0, 0,0,0,1]\n"
               "camera_model: pinhole\nintrinsics: [24, 24, 40, 32]\n"
               "distortion_model: equidistant\ndistortion_coefficients: [0, 0, 0, 0]\n"
               "resolution: [160, 128]\n");
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kBadData, {"cam0/sensor.yaml: resolution"});
}

TEST(Euroc, TimesThatLostTheirDigitsAreAnError) {
  const TestFolder folder;
  WriteEuroc(folder);
  std::string list;
  for (int i = 0; i < 8; ++i) list += std::to_string(1403715273000000000 + i / 4) + ",a.png\n";
  folder.Write("mav0/cam0/data.csv", list);
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kBadData, {"6 of 8 lines repeat a time"});
}

TEST(Euroc, AcceptsTheInnerFolderAndRecordingsWithoutImu) {
  const TestFolder folder;
  WriteEuroc(folder);
  folder.Remove("mav0/imu0");
  const auto recording = ReadEuroc(folder.path() / "mav0", {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_TRUE(recording->imu.empty());
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("imu0 is not there"));
}

// A quarter turn on the spot, then 1 m ahead: the increment is in the body at its begin.
TEST(Euroc, WheelPosesBecomeIncrements) {
  const TestFolder folder;
  WriteEuroc(folder);
  folder.Write("mav0/odom0/data.csv",
               "#t_ns,x,y,yaw,v,w\n1000000000,5,5,0,0,0\n1050000000,5,5,1.5707963267948966,0,0\n"
               "1100000000,5,6,1.5707963267948966,1,0\n");
  auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->wheel.size(), 2u);
  EXPECT_NEAR(recording->wheel[0].dyaw_rad, M_PI / 2, 1e-12);
  EXPECT_NEAR(recording->wheel[0].dx_m, 0, 1e-12);
  EXPECT_NEAR(recording->wheel[1].dx_m, 1, 1e-12);
  EXPECT_NEAR(recording->wheel[1].dy_m, 0, 1e-12);
  EXPECT_EQ(recording->wheel[1].utime_begin, recording->wheel[0].utime);
  DescribeSensors(*recording);
  EXPECT_TRUE(recording->calibration.wheel.present);
  EXPECT_NEAR(recording->calibration.wheel.rate_hz, 20, 1e-9);
  EXPECT_NEAR(recording->calibration.imu.rate_hz, 200, 0.1);
}

// The wheels' frame is 0.4 m under the IMU and turned, as on a robot whose IMU looks through the
// camera's axes. With it as the body everything else has to move: each point of the world seen in a
// sensor before and after is the same.
TEST(Euroc, TheWheelsFrameBecomesTheBody) {
  const std::string list = "#t_ns,x,y,yaw,v,w\n1000000000,0,0,0,0,0\n1050000000,0.1,0,0,2,0\n";
  const TestFolder folder;
  WriteEuroc(folder);
  folder.Write("mav0/odom0/data.csv", list);
  const auto before = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_THAT(AllText(before->warnings), HasSubstr("the wheels' frame is not stated"));

  // x of N is the IMU's z, z of N its -y.
  const std::string T_BS = "[0,-1,0,0.02, 0,0,-1,0.4, 1,0,0,-0.1, 0,0,0,1]";
  folder.Write("mav0/odom0/sensor.yaml",
               "T_BS:\n  cols: 4\n  rows: 4\n  data: " + T_BS +
                   "\nwheel_base: 0.3\nwheel_radius: 0.05\nticks_per_rev: 1000\n");
  const auto after = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_THAT(AllText(after->warnings), testing::Not(HasSubstr("not stated")));
  Eigen::Matrix3d R_BN;
  R_BN << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const SE3 T_BN(Eigen::Quaterniond(R_BN), {0.02, 0.4, -0.1});

  ASSERT_EQ(after->wheel.size(), 1u);
  EXPECT_NEAR(after->wheel[0].dx_m, 0.1, 1e-12);
  ExpectPose(T_BN * after->calibration.imu.T_BI, before->calibration.imu.T_BI);
  ExpectPose(T_BN * after->calibration.camera.T_BC, before->calibration.camera.T_BC);
  ExpectPose(after->calibration.camera.T_C0C1, before->calibration.camera.T_C0C1);
  ASSERT_EQ(after->ground_truth.size(), 1u);
  ExpectPose(after->ground_truth[0].T_GB, before->ground_truth[0].T_GB * T_BN);
  EXPECT_EQ(after->calibration.wheel.track_width_m, 0.3);
  EXPECT_NEAR(after->calibration.wheel.ticks_per_metre, 1000 / (0.1 * M_PI), 1e-9);
}

// The intrinsics are stated for twice the size: those of the images follow, pixel centres included.
TEST(Euroc, IntrinsicsOfAnotherSizeAreScaledOrRefused) {
  const TestFolder folder;
  WriteEuroc(folder);
  std::string yaml = EurocCamera("[0,0,1,0.1, -1,0,0,0.05, 0,-1,0,0, 0,0,0,1]");
  const auto with_resolution = [&](const std::string& resolution) {
    std::string text = yaml;
    return text.replace(text.find("[80, 64]"), 8, resolution);
  };
  folder.Write("mav0/cam0/sensor.yaml", with_resolution("[160, 128]"));
  const auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_NEAR(recording->calibration.camera.left.fx, 229, 1e-9);
  EXPECT_NEAR(recording->calibration.camera.left.cx, 40.5 / 2 - 0.5, 1e-9);
  EXPECT_EQ(recording->calibration.camera.right.fx, 458);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("stated for 160 x 128, the images are 80"));
  folder.Write("mav0/cam0/sensor.yaml", with_resolution("[160, 90]"));
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kBadData,
              {"cam0/sensor.yaml", "160 x 90", "another shape"});
}

TEST(Euroc, ATextFileInPlaceOfALinkIsFollowed) {
  const TestFolder folder;
  WriteEuroc(folder);
  std::filesystem::rename(folder.path() / "mav0/cam1/data", folder.path() / "elsewhere");
  folder.Write("mav0/cam1/data", "../../elsewhere");
  const auto recording = ReadEuroc(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->right.bytes[0], 'b');
}

TEST(Euroc, BadFoldersAreRefusedWithFileAndLine) {
  const std::vector<BadFile> cases = {
      {"mav0/cam0/data.csv", "12.5,a.png\n", {"cam0/data.csv:1: ", "nanoseconds"}},
      {"mav0/cam0/data.csv", "#\n12\n", {"cam0/data.csv:2: the file name"}},
      {"mav0/cam1/data.csv", "12,a.png\n", {"no stamp is near"}},
      {"mav0/cam0/sensor.yaml", EurocCamera("[1,2]"), {"sensor.yaml:4: T_BS"}},
      {"mav0/cam0/sensor.yaml", "distortion_model: omni\n", {"radial-tangential and equidistant"}},
      {"mav0/cam0/sensor.yaml", "camera_model: omni\n", {"camera_model", "only pinhole"}},
      {"mav0/imu0/sensor.yaml", "a: 1\n", {"imu0/sensor.yaml:1: T_BS: is missing"}},
      {"mav0/imu0/data.csv", "1,2,3,4,5,6\n", {"imu0/data.csv:1: "}},
      {"mav0/imu0/data.csv", "1,nan,1,1,1,1,1\n", {"imu0/data.csv:1: ", "1 of 1 rows"}},
      {"mav0/odom0/data.csv", "1,2\n", {"odom0/data.csv:1: "}},
      {"mav0/odom0/sensor.yaml", "T_BS: [1]\n", {"odom0/sensor.yaml:1: T_BS"}},
      {"mav0/odom0/sensor.yaml",
       "T_BS: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nwheel_base: -1\n",
       {"odom0/sensor.yaml:2: wheel_base", "positive"}},
  };
  const auto write_with_wheels = [](const TestFolder& folder) {
    WriteEuroc(folder);
    folder.Write("mav0/odom0/data.csv", "1000000000,0,0,0\n1050000000,0.1,0,0\n");
  };
  ExpectRefused(cases, write_with_wheels, [](const auto& path) { return ReadEuroc(path, {}); });
  const TestFolder folder;
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kNotFound, {"mav0"});
  WriteEuroc(folder);
  folder.Remove("mav0/cam1");
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kNotFound, {"cam1", "stereo"});
}

}  // namespace
}  // namespace gw::importer

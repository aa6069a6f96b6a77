// The OpenLORIS importer on a small folder made here, and every way in which the folder can be
// wrong.
#include "tools/data/import/openloris.h"

#include <gmock/gmock.h>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

void WriteOpenLorisOdometry(const TestFolder& folder) {
  folder.Write("odom.txt",
               "# t p q\n50.00 -3 1 0 0 0 0.70710678 0.70710678\n"
               "50.05 -3 1.5 0 0 0 0.70710678 0.70710678 9 9 9 9 9 9\n");
  folder.Write("groundtruth.txt", "# t p q\n50.01 21 22 0 0 0 0 1\n50.04 21.5 22 0 0 0 0 1\n");
}

void WriteOpenLoris(const TestFolder& folder) {
  WriteOpenLorisOdometry(folder);
  folder.Write("color.txt", "#\n50.000 color/a.png\n50.033 color/b.png\n");
  folder.Write("aligned_depth.txt", "50.001 aligned_depth/a.png\n50.034 aligned_depth/b.png\n");
  for (const char* name : {"a", "b"}) {
    folder.WriteGrey(std::string("color/") + name + ".png", *name);
    folder.WriteDepth(std::string("aligned_depth/") + name + ".png", *name);
  }
  folder.Write("d400_gyroscope.txt", "49.998 1 2 3\n50.002 1 2 3\n50.004 1 2 3\n");
  folder.Write("d400_accelerometer.txt", "50.000 0 0 8\n50.004 0 0 10\n");
  folder.Write("sensors.yaml",
               "%YAML:1.0\nd400_color_optical_frame:\n   fps: 30\n   width: 80\n   height: 64\n"
               "   intrinsics: !!opencv-matrix\n      rows: 1\n      cols: 4\n      dt: d\n"
               "      data: [ 611.0, 43.0, 612.0, 24.0 ]\n"
               "   distortion_model: radial-tangential\n"
               "   distortion_coefficients: !!opencv-matrix\n      rows: 1\n      cols: 5\n"
               "      dt: d\n      data: [ 0., 0., 0., 0., 0. ]\n");
  folder.Write("trans_matrix.yaml",
               "%YAML:1.0\ntrans_matrix:\n"
               "   -\n      parent_frame: d400_link\n      child_frame: d400_color_optical_frame\n"
               "      matrix: !!opencv-matrix\n         rows: 4\n         cols: 4\n         dt: d\n"
               "         data: [0,0,1,0, -1,0,0,0.02, 0,-1,0,0, 0,0,0,1]\n"
               "   -\n      parent_frame: base_link\n      child_frame: d400_link\n"
               "      matrix: !!opencv-matrix\n         rows: 4\n         cols: 4\n         dt: d\n"
               "         data: [1,0,0,0.4, 0,1,0,0, 0,0,1,1.2, 0,0,0,1]\n"
               "   -\n      parent_frame: d400_gyroscope\n      child_frame: d400_link\n"
               "      matrix: !!opencv-matrix\n         rows: 4\n         cols: 4\n         dt: d\n"
               "         data: [1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n");
}

TEST(OpenLoris, ReadsRgbdImuAndChainsTheFrames) {
  const TestFolder folder;
  WriteOpenLoris(folder);
  const auto recording = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.left.fx, 611);
  EXPECT_EQ(camera.left.cx, 43);
  EXPECT_EQ(camera.left.fy, 612);
  EXPECT_EQ(camera.left.cy, 24);
  EXPECT_TRUE(camera.T_BC.translation().isApprox(Eigen::Vector3d(0.4, 0.02, 1.2)));
  // The gyro's entry is given the other way round.
  EXPECT_TRUE(
      recording->calibration.imu.T_BI.translation().isApprox(Eigen::Vector3d(-0.1, 0, 1.2)));
  EXPECT_EQ(recording->frames->size(), 2u);
}

TEST(OpenLoris, AccelerometerIsInterpolatedToTheGyro) {
  const TestFolder folder;
  WriteOpenLoris(folder);
  const auto recording = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->imu.size(), 3u);
  EXPECT_FALSE(recording->imu[0].has_accel);  // before the first accelerometer sample
  EXPECT_TRUE(recording->imu[1].has_accel);
  EXPECT_NEAR(recording->imu[1].a_I_m_s2.z(), 9, 1e-9);
  EXPECT_EQ(recording->imu[2].a_I_m_s2.z(), 10);
}

TEST(OpenLoris, OdometryAndGroundTruthAloneMakeARecording) {
  const TestFolder folder;
  WriteOpenLorisOdometry(folder);
  const auto recording = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->frames, nullptr);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("no images in the log"));
  ASSERT_EQ(recording->wheel.size(), 1u);
  EXPECT_NEAR(recording->wheel[0].dx_m, 0.5, 1e-6);
  EXPECT_NEAR(recording->wheel[0].dy_m, 0, 1e-6);
  EXPECT_EQ(recording->ground_truth.size(), 2u);
}

std::string FrameEntry(const std::string& parent, const std::string& child,
                       const std::string& matrix) {
  return "   -\n      parent_frame: " + parent + "\n      child_frame: " + child +
         "\n      matrix: !!opencv-matrix\n         rows: 4\n         cols: 4\n         dt: d\n"
         "         data: [" +
         matrix + "]\n";
}

void Append(const TestFolder& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder.path() / name, std::ios::app) << text;
}

// A recording of the two infrared cameras: the list of depth is missing, infra2.txt is there.
TEST(OpenLoris, WithoutDepthTheInfraredPairIsStereo) {
  const TestFolder folder;
  WriteOpenLoris(folder);
  folder.Remove("aligned_depth.txt");
  folder.Write("infra2.txt", "50.000 infra2/a.png\n50.033 infra2/b.png\n");
  for (const char* name : {"a", "b"}) {
    folder.WriteGrey(std::string("infra2/") + name + ".png", *name + 1);
  }
  Append(folder, "sensors.yaml",
         "d400_infra2_optical_frame:\n   intrinsics: [ 600.0, 41.0, 601.0, 25.0 ]\n");
  Append(folder, "trans_matrix.yaml",
         FrameEntry("d400_color_optical_frame", "d400_infra2_optical_frame",
                    "1,0,0,0.05, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
  const auto recording = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.kind, CameraKind::kStereo);
  EXPECT_EQ(camera.right.fx, 600);
  EXPECT_NEAR(camera.T_C0C1.translation().x(), 0.05, 1e-12);
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->right.bytes[0], 'b');
  EXPECT_TRUE(pixels->depth.bytes.empty());
  folder.Write("infra2.txt", "50.004 infra2/a.png\n50.037 infra2/b.png\n");
  const auto apart = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(apart) << apart.error().message;
  EXPECT_EQ(apart->frames->size(), 2u);
  EXPECT_THAT(AllText(apart->warnings), testing::HasSubstr("up to 4.0 ms apart"));
  folder.Write("infra2.txt", "50.016 infra2/a.png\n");
  ExpectError(ReadOpenLoris(folder.path(), {}), ErrorCode::kBadData,
              {"right image within 8.25 ms"});
}

TEST(OpenLoris, AllFaultsOfAFolderAreNamedTogether) {
  const TestFolder folder;
  WriteOpenLoris(folder);
  folder.Write("color.txt", "x color/a.png\n");
  folder.Write("d400_accelerometer.txt", "1 2\n");
  folder.Write("odom.txt", "1 2 3\n");
  folder.Write("groundtruth.txt", "1 2 3 4 5 6 7 z\n");
  ExpectError(
      ReadOpenLoris(folder.path(), {}), ErrorCode::kBadData,
      {"color.txt:1: ", "d400_accelerometer.txt:1: ", "odom.txt:1: ", "groundtruth.txt:1: "});
}

TEST(OpenLoris, OdometryRowsThatAreNullAreLeftOutAndCounted) {
  const TestFolder folder;
  folder.Write("odom.txt",
               "t,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,0,1\n1.05,null,null,null,null,null,null,null\n"
               "1.1,,,,,,,\n1.15,0.1,0,0,0,0,0,1\n1.2,0.2,0,0,0,0,0,1\n");
  const auto recording = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->wheel.size(), 2u);
  EXPECT_EQ(recording->wheel[0].utime.us, 1150000);
  EXPECT_THAT(AllText(recording->warnings), testing::HasSubstr("odom.txt:3: "));
  EXPECT_THAT(AllText(recording->warnings), testing::HasSubstr("2 of 5 rows"));
}

// The odometer sits 0.2 m behind base_link: the body moves there, the wheels' increments stay.
TEST(OpenLoris, TheOdometersFrameIsTheBody) {
  const TestFolder folder;
  WriteOpenLoris(folder);
  const auto before = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(before);
  Append(folder, "trans_matrix.yaml",
         FrameEntry("base_link", "odometer", "1,0,0,-0.2, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
  const auto after = ReadOpenLoris(folder.path(), {});
  ASSERT_TRUE(after) << after.error().message;
  const SE3 T_BN(Eigen::Quaterniond::Identity(), {-0.2, 0, 0});
  ExpectPose(T_BN * after->calibration.camera.T_BC, before->calibration.camera.T_BC);
  ExpectPose(T_BN * after->calibration.imu.T_BI, before->calibration.imu.T_BI);
  ExpectPose(after->ground_truth[0].T_GB, before->ground_truth[0].T_GB * T_BN);
  EXPECT_EQ(after->wheel[0].dx_m, before->wheel[0].dx_m);
}

TEST(OpenLoris, BadFoldersAreRefusedWithFileAndLine) {
  const std::vector<BadFile> cases = {
      {"odom.txt", "1 2\n", {"odom.txt:1: "}},
      {"color.txt", "1\n", {"color.txt:1: "}},
      {"aligned_depth.txt", "9 a.png\n", {"within 20 ms"}},
      {"sensors.yaml", "a: 1\n", {"d400_color_optical_frame: this section is missing"}},
      {"sensors.yaml",
       "d400_color_optical_frame:\n  width: 90\n  height: 64\n  intrinsics: [600,40,600,32]\n",
       {"sensors.yaml: d400_color_optical_frame", "90 x 64", "80 x 64"}},
      {"trans_matrix.yaml", "a: 1\n", {"trans_matrix: this list is missing"}},
      {"trans_matrix.yaml", "trans_matrix:\n  - {parent_frame: a, child_frame: b}\n", {"matrix"}},
      {"trans_matrix.yaml",
       "trans_matrix:\n  - {parent_frame: a, child_frame: base_link, matrix: [1,0,0,0, 0,1,0,0, "
       "0,0,1,0, 0,0,0,1]}\n",
       {"no chain of frames leads from base_link to d400_color_optical_frame"}},
      {"d400_gyroscope.txt", "1 2 3\n", {"d400_gyroscope.txt:1: "}},
  };
  ExpectRefused(cases, WriteOpenLoris, [](const auto& path) { return ReadOpenLoris(path, {}); });
  const TestFolder folder;
  ExpectError(ReadOpenLoris(folder.path(), {}), ErrorCode::kNotFound, {"odom.txt"});
}

}  // namespace
}  // namespace gw::importer

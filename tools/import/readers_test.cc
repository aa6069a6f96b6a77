// Each importer on a small folder made here, and every way in which the folder can be wrong.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "tools/import/cid_sims.h"
#include "tools/import/euroc.h"
#include "tools/import/image_file.h"
#include "tools/import/kitti.h"
#include "tools/import/openloris.h"
#include "tools/import/test_folder.h"
#include "tools/import/tum.h"

namespace gw::importer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// What a bad folder must lead to.
void ExpectError(const Result<Recording>& result, ErrorCode code,
                 const std::vector<std::string>& parts) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, code) << result.error().message;
  for (const std::string& part : parts) EXPECT_THAT(result.error().message, HasSubstr(part));
}

void ExpectPose(const SE3& actual, const SE3& expected, double tolerance = 1e-9) {
  EXPECT_LT((expected.inverse() * actual).Log().norm(), tolerance);
}

// ------------------------------------------------------------------------------------------- TUM

// Three images, of which the last has no depth; ground truth of the optical frame.
void WriteTum(const TestFolder& folder) {
  folder.Write("rgb.txt",
               "# t file\n10.000000 rgb/a.png\n10.033333 rgb/b.png\n10.066667 rgb/c.png\n");
  folder.Write("depth.txt", "# t file\n10.004000 depth/a.png\n10.030000 depth/b.png\n");
  folder.Write("groundtruth.txt",
               "# t\n9.9 0 0 0 0 0 0 1\n10.0 1 2 3 -0.5 0.5 -0.5 0.5\n10.1 1 2 3 0 0 0 1\n");
  for (const char* name : {"a", "b", "c"})
    folder.WriteGrey(std::string("rgb/") + name + ".png", *name);
  folder.WriteDepth("depth/a.png", 5);
  folder.WriteDepth("depth/b.png", 6);
}

TEST(Tum, PairsByTimeAndKeepsPixels) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames->size(), 2u);
  EXPECT_EQ(recording->frames->utime(1).us, 10033333);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("1 images have no depth image"));
  const auto pixels = recording->frames->Load(1);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.format, PixelFormat::kGray8);
  EXPECT_EQ(pixels->left.bytes[80 * 3 + 7], 'b' + 10);
  EXPECT_EQ(pixels->depth.format, PixelFormat::kDepth16);
  const auto* depth = reinterpret_cast<const uint16_t*>(pixels->depth.bytes.data());
  EXPECT_EQ(depth[80 * 3 + 70], 257 * 70 + 3 + 6);
  EXPECT_TRUE(pixels->right.bytes.empty());
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.width, 80);
  EXPECT_EQ(camera.height, 64);
  EXPECT_EQ(camera.left.fx, 517.3);
  EXPECT_NEAR(camera.rate_hz, 30, 0.01);
  EXPECT_NEAR(camera.depth_unit_m, 0.0002, 1e-12);
}

// The second ground-truth pose has the optical frame turned as T_BC is: the body is level.
TEST(Tum, GroundTruthIsMovedFromTheOpticalFrameToTheBody) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->ground_truth.size(), 3u);
  ExpectPose(recording->ground_truth[1].T_GB, SE3(Eigen::Quaterniond::Identity(), {1, 2, 3}));
  for (const GroundTruth& truth : recording->ground_truth) {
    EXPECT_LT((truth.T_GB * recording->calibration.camera.T_BC).translation().norm(), 4);
  }
}

TEST(Tum, ColourBecomesGreyByTheStatedFormula) {
  const TestFolder folder;
  WriteTum(folder);
  folder.WriteImage("rgb/a.png", cv::Mat(64, 80, CV_8UC3, cv::Scalar(10, 20, 200)));  // b, g, r
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording);
  const auto pixels = recording->frames->Load(0);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.bytes[0], std::lround(0.299 * 200 + 0.587 * 20 + 0.114 * 10));
  bool stated = false;
  for (const auto& [key, text] : recording->notes) {
    stated |= key == "images" && text.find(kGreyConversion) != std::string::npos;
  }
  EXPECT_TRUE(stated);
}

TEST(Tum, IntrinsicsOfTheCommandLineReplaceThePreset) {
  const TestFolder folder;
  WriteTum(folder);
  TumOptions options;
  options.intrinsics = *ParseIntrinsics("500,501,40,32");
  const auto recording = ReadTum(folder.path(), options);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->calibration.camera.left.fy, 501);
  EXPECT_FALSE(recording->calibration.camera.left.distorted());
  EXPECT_EQ(ParseIntrinsics("1,2,3,4,5,6,7,8,9")->radtan[4], 9);
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5", "a,2,3,4", "1,2,3,4,", "0,2,3,4", "1;2;3;4"}) {
    EXPECT_FALSE(ParseIntrinsics(bad)) << bad;
  }
}

TEST(Tum, MissingFilesAreNamedOrSkipped) {
  const TestFolder folder;
  WriteTum(folder);
  folder.Remove("depth/a.png");
  ExpectError(ReadTum(folder.path(), {}), ErrorCode::kNotFound,
              {"rgb.txt:2: ", "depth/a.png", "--skip-missing"});
  TumOptions options;
  options.skip_missing = true;
  const auto recording = ReadTum(folder.path(), options);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->frames->size(), 1u);
  EXPECT_EQ(recording->skipped_frames, 1);
  folder.Remove("depth/b.png");
  ExpectError(ReadTum(folder.path(), options), ErrorCode::kNotFound, {"no complete frame"});
}

TEST(Tum, BadFoldersAreRefusedWithFileAndLine) {
  const struct {
    const char* file;
    const char* text;
    ErrorCode code;
    std::vector<std::string> message;
  } cases[] = {
      {"rgb.txt", "", ErrorCode::kBadData, {"rgb.txt: holds no record"}},
      {"rgb.txt", "10.0\n", ErrorCode::kBadData, {"rgb.txt:1: the file name is missing"}},
      {"rgb.txt", "#\nx rgb/a.png\n", ErrorCode::kBadData, {"rgb.txt:2: 'x'"}},
      {"depth.txt", "20.0 depth/a.png\n", ErrorCode::kBadData, {"within 20 ms"}},
      {"groundtruth.txt", "1 2 3\n", ErrorCode::kBadData, {"groundtruth.txt:1: ", "fields"}},
      {"groundtruth.txt",
       "1 2 3 4 0 0 0 0\n",
       ErrorCode::kBadData,
       {"groundtruth.txt:1: ", "norm"}},
      {"groundtruth.txt", "1 2 3 4 0 0 0 inf\n", ErrorCode::kBadData, {"groundtruth.txt:1: "}},
  };
  for (const auto& c : cases) {
    const TestFolder folder;
    WriteTum(folder);
    folder.Write(c.file, c.text);
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    ExpectError(ReadTum(folder.path(), {}), c.code, c.message);
  }
  const TestFolder folder;
  ExpectError(ReadTum(folder.path(), {}), ErrorCode::kNotFound, {"rgb.txt: not there"});
  WriteTum(folder);
  TumOptions options;
  options.camera = "fr4";
  ExpectError(ReadTum(folder.path(), options), ErrorCode::kInvalidArgument, {"fr4"});
}

TEST(Tum, BadImagesAreRefusedWhenTheyAreRead) {
  const TestFolder folder;
  WriteTum(folder);
  const auto recording = ReadTum(folder.path(), {});
  ASSERT_TRUE(recording);
  const auto error_of_frame = [&] {
    const auto pixels = recording->frames->Load(1);
    return pixels ? std::string("no error") : pixels.error().message;
  };
  folder.WriteGrey("rgb/b.png", 0, 64, 64);
  EXPECT_THAT(error_of_frame(), AllOf(HasSubstr("b.png"), HasSubstr("is 64 x 64")));
  folder.WriteDepth("rgb/b.png", 0);
  EXPECT_THAT(error_of_frame(), HasSubstr("16-bit, 1 channels"));
  folder.Write("rgb/b.png", "no image");
  EXPECT_THAT(error_of_frame(), HasSubstr("cannot be decoded"));
  folder.WriteGrey("rgb/b.png", 0);
  folder.WriteGrey("depth/b.png", 0);
  EXPECT_THAT(error_of_frame(), HasSubstr("16-bit depth"));
  folder.WriteDepth("depth/b.png", 0);
  EXPECT_EQ(error_of_frame(), "no error");
  std::filesystem::resize_file(folder.path() / "rgb/b.png", 200);
  EXPECT_THAT(error_of_frame(), HasSubstr("cannot be decoded"));
  folder.Remove("rgb/b.png");
  EXPECT_THAT(error_of_frame(), HasSubstr("not there"));
}

// ----------------------------------------------------------------------------------------- KITTI

void WriteKitti(const TestFolder& folder) {
  folder.Write("calib.txt",
               "P0: 700 0 40 0 0 700 32 0 0 0 1 0\nP1: 700 0 40 -350 0 700 32 0 0 0 1 0\n"
               "P2: 700 0 40 0 0 700 32 0 0 0 1 0\n");
  folder.Write("times.txt", "0.000000e+00\n1.037980e-01\n");
  folder.Write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 2\n");
  for (const char* name :
       {"image_0/000000.png", "image_1/000000.png", "image_0/000001.png", "image_1/000001.png"}) {
    folder.WriteGrey(name, name[6]);
  }
}

TEST(Kitti, ReadsRectifiedStereo) {
  const TestFolder folder;
  WriteKitti(folder);
  const auto recording = ReadKitti(folder.path(), {});
  ASSERT_TRUE(recording) << recording.error().message;
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.kind, CameraKind::kStereo);
  EXPECT_NEAR(camera.T_C0C1.translation().x(), 0.5, 1e-12);
  EXPECT_NEAR(camera.depth_max_m, 70, 1e-9);  // 700 px * 0.5 m / 5 px
  EXPECT_LT(camera.depth_min_m, camera.depth_max_m);
  EXPECT_EQ(recording->frames->utime(1).us, 103798);
  const auto pixels = recording->frames->Load(1);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->left.bytes[0], '0');
  EXPECT_EQ(pixels->right.bytes[0], '1');
}

// 1 m to the right and 2 m ahead of the camera is 2 m ahead and 1 m to the right of the body.
TEST(Kitti, GroundTruthIsInTheFirstBodyFrame) {
  const TestFolder folder;
  WriteKitti(folder);
  const auto recording = ReadKitti(folder.path(), {});
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->ground_truth.size(), 2u);
  ExpectPose(recording->ground_truth[0].T_GB, SE3());
  ExpectPose(recording->ground_truth[1].T_GB, SE3(Eigen::Quaterniond::Identity(), {2, -1, 0}));
}

TEST(Kitti, BadFoldersAreRefusedWithFileAndLine) {
  const struct {
    const char* file;
    const char* text;
    std::vector<std::string> message;
  } cases[] = {
      {"calib.txt", "P0: 700 0 40 0 0 700 32 0 0 0 1 0\n", {"calib.txt: P0 or P1 is missing"}},
      {"calib.txt", "P0: 700 0 40\n", {"calib.txt:1: "}},
      {"calib.txt", "P0: 0 0 40 0 0 700 32 0 0 0 1 0\n", {"calib.txt:1: ", "focal"}},
      {"calib.txt",
       "P0: 700 0 40 0 0 700 32 0 0 0 1 0\nP1: 700 0 40 350 0 700 32 0 0 0 1 0\n",
       {"swapped"}},
      {"times.txt", "0\n0\n", {"times.txt:2: ", "does not increase"}},
      {"times.txt", "0\n1\n2\n", {"times.txt:3: ", "000002.png"}},
      {"poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n", {"poses.txt: holds 1 poses"}},
      {"poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n2 0 0 1 0 1 0 0 0 0 1 2\n", {"poses.txt:2: "}},
  };
  for (const auto& c : cases) {
    const TestFolder folder;
    WriteKitti(folder);
    folder.Write(c.file, c.text);
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const auto recording = ReadKitti(folder.path(), {});
    ASSERT_FALSE(recording);
    for (const auto& part : c.message) EXPECT_THAT(recording.error().message, HasSubstr(part));
  }
}

// ----------------------------------------------------------------------------------------- EuRoC

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

TEST(Euroc, BadFoldersAreRefusedWithFileAndLine) {
  const struct {
    const char* file;
    std::string text;
    std::vector<std::string> message;
  } cases[] = {
      {"mav0/cam0/data.csv", "12.5,a.png\n", {"cam0/data.csv:1: ", "nanoseconds"}},
      {"mav0/cam0/data.csv", "#\n12\n", {"cam0/data.csv:2: the file name"}},
      {"mav0/cam1/data.csv", "12,a.png\n", {"no stamp equals"}},
      {"mav0/cam0/sensor.yaml", EurocCamera("[1,2]"), {"sensor.yaml:4: T_BS"}},
      {"mav0/cam0/sensor.yaml", "distortion_model: equidistant\n", {"only radial-tangential"}},
      {"mav0/imu0/sensor.yaml", "a: 1\n", {"imu0/sensor.yaml:1: T_BS: is missing"}},
      {"mav0/imu0/data.csv", "1,2,3,4,5,6\n", {"imu0/data.csv:1: "}},
      {"mav0/state_groundtruth_estimate0/data.csv", "1,1,2,3,0,0,0,0\n", {"data.csv:1: ", "norm"}},
      {"mav0/odom0/data.csv", "1,2\n", {"odom0/data.csv:1: "}},
  };
  for (const auto& c : cases) {
    const TestFolder folder;
    WriteEuroc(folder);
    folder.Write(c.file, c.text);
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const auto recording = ReadEuroc(folder.path(), {});
    ASSERT_FALSE(recording);
    for (const auto& part : c.message) EXPECT_THAT(recording.error().message, HasSubstr(part));
  }
  const TestFolder folder;
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kNotFound, {"mav0"});
  WriteEuroc(folder);
  folder.Remove("mav0/cam1");
  ExpectError(ReadEuroc(folder.path(), {}), ErrorCode::kNotFound, {"cam1", "stereo"});
}

// -------------------------------------------------------------------------------------- CID-SIMS

constexpr const char* kCidCalibration =
    "%YAML:1.0\n# imu\ngyroscope_noise_density:  0.00018\ngyroscope_random_walk: 2.8e-05\n"
    "accelerometer_noise_density: 0.0011\naccelerometer_random_walk: 0.00027\n"
    "depth_factor: 1000 # mm\ncam_width: 640\ncam_height: 480\n"
    "cam_k: !!opencv-matrix\n  rows: 4\n  cols: 1\n  dt: d\n  data: [386.5, 387.3, 40.5, 32.4]\n"
    "cam_d: !!opencv-matrix\n  rows: 4\n  cols: 1\n  dt: d\n  data: [-0.046, 0.035, 0.0002, "
    "-0.0003]\n"
    "T_ItoC: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: d\n"
    // 0.1 rad about y.
    "  data: [\n    0.99500417, 0, 0.09983342, -0.027,\n    0, 1, 0, -0.004,\n"
    "    -0.09983342, 0, 0.99500417, -0.016,\n    0., 0., 0., 1.]\n"
    "timeshift_CtoI: -0.0097648780485 # t_imu = t_cam + shift\n"
    "T_CHtoW: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: d\n"
    "  data: [0.013246,  0.0521412, 0.9982324, 0.28,\n\t-0.9962321, 0.0610127, 0.0024175, 0,\n"
    "\t-0.05647427, -0.9950674, 0.0591213, 0.20,\n\t0, 0, 0, 1]\n"
    "T_CLtoW: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: d\n"
    "  data: [0,0,1,0.37, -1,0,0,0.013, 0,-1,0,0.016, 0,0,0,1]\nwheel_baseline: 0.28\n";

// A camera that turns about its y axis with changing speed; the IMU's frame is turned against the
// camera by the matrix of the calibration, as named or inverted.
void WriteCidSims(const TestFolder& folder, bool matrix_is_inverted = false) {
  folder.Write("calibration.yaml", kCidCalibration);
  folder.Write("associations.txt",
               "100.000000 color/a.png 100.000000 depth/a.png\n"
               "100.033000 color/b.png 100.033000 depth/b.png\n");
  for (const char* name : {"a", "b"}) {
    folder.WriteGrey(std::string("color/") + name + ".png", *name);
    folder.WriteDepth(std::string("depth/") + name + ".png", *name);
  }
  const Eigen::Quaterniond R_CI = ExpSO3({0, matrix_is_inverted ? -0.1 : 0.1, 0});
  std::string truth = "# t p q\n";
  std::string imu;
  Eigen::Quaterniond R_GC = Eigen::Quaterniond::Identity();
  char line[300];
  const double dt = 0.005;
  for (int i = 0; i < 1000; ++i) {
    const double t = 100 + dt * i;
    const Eigen::Vector3d w_C(0.8 * std::sin(0.02 * i), 0.1, 0.5 * std::cos(0.013 * i));
    const Eigen::Vector3d w_I = R_CI.conjugate() * w_C + Eigen::Vector3d(0.01, -0.02, 0.005);
    std::snprintf(line, sizeof line, "%.6f %.9f %.9f %.9f 0 9.8 0\n", t - 0.0097648780485, w_I.x(),
                  w_I.y(), w_I.z());
    imu += line;
    if (i % 6 == 0) {
      std::snprintf(line, sizeof line, "%.6f %.3f 0 0 %.9f %.9f %.9f %.9f\n", t, 0.1 * t, R_GC.x(),
                    R_GC.y(), R_GC.z(), R_GC.w());
      truth += line;
    }
    R_GC = R_GC * ExpSO3(w_C * dt);
  }
  folder.Write("imu.txt", imu);
  folder.Write("pose.txt", truth);
  folder.Write("odom.txt",
               "# t p q v w\n100.00 0 0 0 0 0 0 1 9 9 9 9 9 9\n100.02 0.1 0 0 0 0 0 1 9 9 9 9 9 9\n"
               "100.02 0.1 0 0 0 0 0 1 9 9 9 9 9 9\n");
}

CidSimsOptions Low() {
  CidSimsOptions options;
  options.mount = "low";
  return options;
}

TEST(CidSims, ReadsImagesImuWheelsAndGroundTruth) {
  const TestFolder folder;
  WriteCidSims(folder);
  const auto recording = ReadCidSims(folder.path(), Low());
  ASSERT_TRUE(recording) << recording.error().message;
  const CameraCalibration& camera = recording->calibration.camera;
  EXPECT_EQ(camera.kind, CameraKind::kRgbd);
  EXPECT_EQ(camera.left.fy, 387.3);
  EXPECT_EQ(camera.left.radtan[1], 0.035);
  EXPECT_EQ(camera.depth_unit_m, 0.001);
  EXPECT_EQ(recording->calibration.imu.time_offset_s, -0.0097648780485);
  EXPECT_EQ(recording->calibration.wheel.track_width_m, 0.28);
  EXPECT_EQ(recording->frames->size(), 2u);
  EXPECT_EQ(recording->imu.size(), 1000u);
  ASSERT_EQ(recording->wheel.size(), 1u);
  EXPECT_NEAR(recording->wheel[0].dx_m, 0.1, 1e-12);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("odom.txt: 1 records repeat a time"));
  // The camera moves along x of the ground truth's frame; the body is 0.37 m behind it.
  ASSERT_FALSE(recording->ground_truth.empty());
  ExpectPose(recording->ground_truth[0].T_GB * camera.T_BC,
             SE3(Eigen::Quaterniond::Identity(), {10, 0, 0}), 1e-6);
}

TEST(CidSims, SkewedMountingIsMadeOrthonormalWithAWarning) {
  const TestFolder folder;
  WriteCidSims(folder);
  CidSimsOptions options = Low();
  options.mount = "high";
  const auto recording = ReadCidSims(folder.path(), options);
  ASSERT_TRUE(recording);
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("T_CHtoW: rotation is off orthonormal by"));
  const Eigen::Matrix3d R = recording->calibration.camera.T_BC.rotation().toRotationMatrix();
  EXPECT_NEAR(R(0, 2), 0.998, 3e-3);  // the camera looks ahead
}

TEST(CidSims, MeaningOfTheImuMatrixIsDecidedByTheGyro) {
  for (const bool inverted : {false, true}) {
    const TestFolder folder;
    WriteCidSims(folder, inverted);
    const auto recording = ReadCidSims(folder.path(), Low());
    ASSERT_TRUE(recording);
    const SE3 T_CI = recording->calibration.camera.T_BC.inverse() * recording->calibration.imu.T_BI;
    EXPECT_NEAR(LogSO3(T_CI.rotation()).y(), inverted ? -0.1 : 0.1, 1e-6) << inverted;
  }
}

TEST(CidSims, MeaningOfTheImuMatrixCanBeForced) {
  const TestFolder folder;
  WriteCidSims(folder);
  CidSimsOptions options = Low();
  options.imu_matrix = ImuMatrix::kCameraToImu;
  const auto recording = ReadCidSims(folder.path(), options);
  ASSERT_TRUE(recording);
  const SE3 T_CI = recording->calibration.camera.T_BC.inverse() * recording->calibration.imu.T_BI;
  EXPECT_NEAR(LogSO3(T_CI.rotation()).y(), -0.1, 1e-6);
}

TEST(CidSims, BadFoldersAreRefusedWithFileAndLine) {
  const struct {
    const char* file;
    const char* text;
    std::vector<std::string> message;
  } cases[] = {
      {"associations.txt", "1 color/a.png\n", {"associations.txt:1: "}},
      {"associations.txt", "1 color/x.png 1 depth/a.png\n", {"associations.txt:1: ", "x.png"}},
      {"imu.txt", "1 2 3\n", {"imu.txt:1: "}},
      {"odom.txt", "1 2 3\n", {"odom.txt:1: "}},
      {"pose.txt", "1 2 3\n", {"pose.txt:1: "}},
      {"calibration.yaml", "cam_k: [1, 2, 3]\n", {"calibration.yaml:1: cam_k"}},
  };
  for (const auto& c : cases) {
    const TestFolder folder;
    WriteCidSims(folder);
    folder.Write(c.file, c.text);
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const auto recording = ReadCidSims(folder.path(), Low());
    ASSERT_FALSE(recording);
    for (const auto& part : c.message) EXPECT_THAT(recording.error().message, HasSubstr(part));
  }
  const TestFolder folder;
  WriteCidSims(folder);
  ExpectError(ReadCidSims(folder.path(), {}), ErrorCode::kInvalidArgument, {"--mount high|low"});
  folder.Remove("calibration.yaml");
  ExpectError(ReadCidSims(folder.path(), Low()), ErrorCode::kNotFound, {"--calibration FILE"});
}

// ------------------------------------------------------------------------------------- OpenLORIS

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

TEST(OpenLoris, BadFoldersAreRefusedWithFileAndLine) {
  const struct {
    const char* file;
    const char* text;
    std::vector<std::string> message;
  } cases[] = {
      {"odom.txt", "1 2\n", {"odom.txt:1: "}},
      {"color.txt", "1\n", {"color.txt:1: "}},
      {"aligned_depth.txt", "9 a.png\n", {"within 20 ms"}},
      {"sensors.yaml", "a: 1\n", {"d400_color_optical_frame: this section is missing"}},
      {"trans_matrix.yaml", "a: 1\n", {"trans_matrix: this list is missing"}},
      {"trans_matrix.yaml", "trans_matrix:\n  - {parent_frame: a, child_frame: b}\n", {"matrix"}},
      {"trans_matrix.yaml",
       "trans_matrix:\n  - {parent_frame: a, child_frame: base_link, matrix: [1,0,0,0, 0,1,0,0, "
       "0,0,1,0, 0,0,0,1]}\n",
       {"no chain of frames leads from base_link to d400_color_optical_frame"}},
      {"d400_gyroscope.txt", "1 2 3\n", {"d400_gyroscope.txt:1: "}},
  };
  for (const auto& c : cases) {
    const TestFolder folder;
    WriteOpenLoris(folder);
    folder.Write(c.file, c.text);
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const auto recording = ReadOpenLoris(folder.path(), {});
    ASSERT_FALSE(recording);
    for (const auto& part : c.message) EXPECT_THAT(recording.error().message, HasSubstr(part));
  }
  const TestFolder folder;
  ExpectError(ReadOpenLoris(folder.path(), {}), ErrorCode::kNotFound, {"odom.txt"});
}

}  // namespace
}  // namespace gw::importer

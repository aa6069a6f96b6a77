// The CID-SIMS importer on a small folder made here, and every way in which the folder can be
// wrong.
#include "tools/data/import/cid_sims.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

constexpr const char* kCidCalibration =
    "%YAML:1.0\n# imu\ngyroscope_noise_density:  0.00018\ngyroscope_random_walk: 2.8e-05\n"
    "accelerometer_noise_density: 0.0011\naccelerometer_random_walk: 0.00027\n"
    "depth_factor: 1000 # mm\ncam_width: 80\ncam_height: 64\n"
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
  EXPECT_THAT(AllText(recording->warnings), HasSubstr("odom.txt: 1 of 3 records repeat a time"));
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
  const std::vector<BadFile> cases = {
      {"associations.txt", "1 color/a.png\n", {"associations.txt:1: "}},
      {"associations.txt", "1 color/x.png 1 depth/a.png\n", {"associations.txt:1: ", "x.png"}},
      {"imu.txt", "1 2 3\n", {"imu.txt:1: "}},
      {"odom.txt", "1 2 3\n", {"odom.txt:1: "}},
      {"pose.txt", "1 2 3\n", {"pose.txt:1: "}},
      {"calibration.yaml", "cam_k: [1, 2, 3]\n", {"calibration.yaml:1: cam_k"}},
  };
  ExpectRefused(
      cases, [](const TestFolder& folder) { WriteCidSims(folder); },
      [](const auto& path) { return ReadCidSims(path, Low()); });
  const TestFolder folder;
  WriteCidSims(folder);
  ExpectError(ReadCidSims(folder.path(), {}), ErrorCode::kInvalidArgument, {"--mount high|low"});
  folder.Remove("calibration.yaml");
  ExpectError(ReadCidSims(folder.path(), Low()), ErrorCode::kNotFound, {"--calibration FILE"});
}

}  // namespace
}  // namespace gw::importer

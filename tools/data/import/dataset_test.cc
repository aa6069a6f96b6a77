// The importers on real recordings (shared data folder); skipped where that is absent.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "common/camera/camera_model.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/import/cid_sims.h"
#include "tools/data/import/euroc.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/kitti.h"
#include "tools/data/import/odometry.h"
#include "tools/data/import/openloris.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/test_folder.h"
#include "tools/data/import/trajectory.h"
#include "tools/data/import/tum.h"
#include "tools/data/import/write_log.h"
#include "tools/data/log/inspect.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class Dataset : public testing::Test {
 protected:
  // Skips the test when the recording is absent.
  fs::path Find(const std::string& name) {
    const fs::path path = SharedData() / name;
    return !SharedData().empty() && fs::exists(path) ? path : fs::path();
  }
};
#define GW_FIND_OR_SKIP(variable, name)                                                           \
  const fs::path variable = Find(name);                                                           \
  if ((variable).empty()) {                                                                       \
    GTEST_SKIP() << "no recording " << (name) << "; set GW_SHARED_DIR to the shared folder that " \
                 << "holds data/" << (name);                                                      \
  }

// Every camera message of the log holds exactly the pixels of the files.
void ExpectLogEqualsSource(const Recording& recording, const fs::path& log) {
  auto reader = process::EventLogReader::Open(log.string());
  ASSERT_TRUE(reader);
  size_t index = 0;
  while (const auto event = reader->Next()) {
    if (event->channel != wire::kCamera) continue;
    const auto camera = wire::Decode<wire::DecodedCamera>(event->data);
    ASSERT_TRUE(camera);
    const auto pixels = recording.frames->Load(index);
    ASSERT_TRUE(pixels);
    EXPECT_EQ(camera->frame.utime, recording.frames->utime(index));
    for (const auto& [view, image] : {std::pair{camera->frame.left, &pixels->left},
                                      {camera->frame.right, &pixels->right},
                                      {camera->frame.depth, &pixels->depth}}) {
      ASSERT_EQ(view.empty(), image->bytes.empty());
      if (view.empty()) continue;
      const int row_bytes = image->width * BytesPerPixel(image->format);
      for (int y = 0; y < image->height; ++y) {
        ASSERT_EQ(std::memcmp(view.data + y * view.stride, image->bytes.data() + y * row_bytes,
                              static_cast<size_t>(row_bytes)),
                  0);
      }
    }
    ++index;
  }
  EXPECT_EQ(index, recording.frames->size());
}

// Writes, checks and reads back.
void ExpectGoodLog(Recording& recording) {
  const TestFolder folder;
  DescribeSensors(recording);
  const auto config = MakeRobotConfig(recording);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_TRUE(MakeCameraGeometry(config->calibration));
  const fs::path log = folder.path() / "o.lcm";
  const auto written = WriteLog(recording, log, false, [](size_t, size_t) {});
  ASSERT_TRUE(written) << written.error().message;
  const auto report = tools::InspectLog(log.string(), tools::InspectDepth::kDecode);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->ok) << tools::ReportText(*report);
  if (recording.frames) ExpectLogEqualsSource(recording, log);
}

TEST_F(Dataset, TumRgbd) {
  GW_FIND_OR_SKIP(source, "tum_fr1_rpy_first400");
  auto recording = ReadTum(source, {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->frames->size(), 400u);
  EXPECT_EQ(recording->ground_truth.size(), 1534u);
  EXPECT_NEAR(recording->calibration.camera.rate_hz, 30, 0.3);
  ExpectGoodLog(*recording);
}

TEST_F(Dataset, KittiStereo) {
  GW_FIND_OR_SKIP(source, "kitti_stereo_51");
  auto recording = ReadKitti(source, {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->frames->size(), 51u);
  EXPECT_NEAR(recording->calibration.camera.T_C0C1.translation().x(), 0.5372, 1e-4);
  // The car drives ahead and stays nearly level.
  const SE3 end = recording->ground_truth.back().T_GB;
  EXPECT_GT(end.translation().x(), 15);
  EXPECT_LT(std::abs(end.translation().z()), 3);
  ExpectGoodLog(*recording);
}

// One drive in two formats: ASL, whose body is the IMU and which states the wheels' frame, and
// OpenLORIS, whose body is base_link. Both must come out as the same robot.
TEST_F(Dataset, WheelsFrameOfAslIsTheBodyOfOpenLoris) {
  for (const char* name : {"rendered_night", "rendered_corridor"}) {
    GW_FIND_OR_SKIP(source, name);
    SCOPED_TRACE(name);
    const auto asl = ReadEuroc(source, {});
    ASSERT_TRUE(asl) << asl.error().message;
    const auto loris = ReadOpenLoris(source / "openloris", {});
    ASSERT_TRUE(loris) << loris.error().message;
    ExpectPose(asl->calibration.camera.T_BC, loris->calibration.camera.T_BC, 1e-6);
    ExpectPose(asl->calibration.imu.T_BI, loris->calibration.imu.T_BI, 1e-6);
    ASSERT_EQ(asl->ground_truth.size(), loris->ground_truth.size());
    for (size_t i = 0; i < asl->ground_truth.size(); ++i) {
      ASSERT_EQ(asl->ground_truth[i].utime, loris->ground_truth[i].utime);
      ExpectPose(asl->ground_truth[i].T_GB, loris->ground_truth[i].T_GB, 1e-5);
    }
    ASSERT_EQ(asl->wheel.size(), loris->wheel.size());
    for (size_t i = 0; i < asl->wheel.size(); ++i) {
      EXPECT_NEAR(asl->wheel[i].dx_m, loris->wheel[i].dx_m, 2e-6);
      EXPECT_NEAR(asl->wheel[i].dyaw_rad, loris->wheel[i].dyaw_rad, 1e-6);
    }
  }
}

TEST_F(Dataset, EurocStereoInertial) {
  GW_FIND_OR_SKIP(source, "euroc_v101_static");
  auto recording = ReadEuroc(source, {});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->frames->size(), 40u);
  EXPECT_NEAR(recording->calibration.camera.T_C0C1.translation().norm(), 0.110, 1e-3);
  // At rest the accelerometer measures gravity.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : recording->imu) mean += sample.a_I_m_s2;
  EXPECT_NEAR((mean / static_cast<double>(recording->imu.size())).norm(), 9.81, 0.1);
  ExpectGoodLog(*recording);
}

// Over two seconds wheel odometry is good to centimetres; with the increments in the wrong frame
// the error would be as long as the way.
TEST_F(Dataset, OpenLorisOdometryFollowsTheGroundTruth) {
  GW_FIND_OR_SKIP(source, "openloris_odometry");
  for (const auto& run : fs::directory_iterator(source)) {
    SCOPED_TRACE(run.path().filename().string());
    auto recording = ReadOpenLoris(run.path(), {});
    ASSERT_TRUE(recording) << recording.error().message;
    std::vector<StampedPose> truth;
    for (const GroundTruth& sample : recording->ground_truth) {
      truth.push_back({sample.utime, sample.T_GB});
    }
    double way = 0;
    double error = 0;
    SE3 T_BaBt;
    Utime a = recording->wheel.front().utime_begin;
    for (const WheelSample& w : recording->wheel) {
      T_BaBt = T_BaBt * SE3(ExpSO3({0, 0, w.dyaw_rad}), {w.dx_m, w.dy_m, 0});
      if ((w.utime - a).seconds() < 2) continue;
      if (a >= truth.front().utime && w.utime <= truth.back().utime) {
        const SE3 T_true = PoseAt(truth, a).inverse() * PoseAt(truth, w.utime);
        way += T_BaBt.translation().norm();
        error += (T_true.translation() - T_BaBt.translation()).norm();
      }
      T_BaBt = SE3();
      a = w.utime;
    }
    EXPECT_GT(way, 1);
    EXPECT_LT(error, 0.15 * way) << "way " << way << " m";
    ExpectGoodLog(*recording);
  }
}

TEST_F(Dataset, CidSimsCalibrationAndAssociations) {
  GW_FIND_OR_SKIP(source, "cid_sims_format");
  const TestFolder folder;
  fs::copy_file(source / "calibration.yaml", folder.path() / "calibration.yaml");
  fs::copy_file(source / "floor13_1_associated.txt", folder.path() / "associations.txt");
  // The images are not here: two of the 5336 frames are made, the others count as skipped.
  for (const char* name : {"1673420449.701343", "1673420449.734689"}) {
    folder.WriteImage(std::string("color/") + name + ".png",
                      cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 2, 3)));
    folder.WriteImage(std::string("depth/") + name + ".png", cv::Mat(480, 640, CV_16UC1, 1000.0));
  }
  CidSimsOptions options;
  options.skip_missing = true;
  for (const char* mount : {"high", "low"}) {
    options.mount = mount;
    auto recording = ReadCidSims(folder.path(), options);
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_EQ(recording->frames->size(), 2u);
    EXPECT_EQ(recording->skipped_frames, 5334);
    EXPECT_THAT(AllText(recording->warnings), HasSubstr("rotation is off orthonormal by 0.007"));
    EXPECT_NEAR(recording->calibration.imu.time_offset_s, -0.00976, 1e-5);
    ExpectGoodLog(*recording);
  }
}

// Wheels and IMU of a real skid-steer robot; its accelerometer counts in g.
TEST_F(Dataset, SkidSteerWheelsAndImu) {
  for (const char* name : {"skid_steer_run20", "skid_steer_run21"}) {
    GW_FIND_OR_SKIP(source, std::string("wheels_and_imu/") + name);
    OdometryOptions options;
    options.imu = source / "imu.csv";
    auto recording = ReadOdometry(source / "odom_wheel_only.txt", options);
    ASSERT_TRUE(recording) << recording.error().message;
    CheckImu({}, *recording);
    EXPECT_THAT(AllText(recording->warnings), HasSubstr("the accelerometer is in g"));
    EXPECT_NEAR(recording->imu.front().a_I_m_s2.norm(), 9.8, 0.5);
    ExpectGoodLog(*recording);
  }
}

// The encoders' own readings and the odometry made from them drive the same way, with and without
// its resampling.
TEST_F(Dataset, EncodersAndOdometryAgree) {
  GW_FIND_OR_SKIP(source, "wheels_and_imu/rendered_office_easy");
  OpenLorisOptions options;
  const auto odometry = ReadOpenLoris(source, options);
  options.encoders = source / "encoder.txt";
  options.ticks_per_turn = 2578.33;
  auto encoders = ReadOpenLoris(source, options);
  ASSERT_TRUE(odometry && encoders);
  const auto end = [](const std::vector<WheelSample>& wheels) {
    SE3 T_OB;
    for (const WheelSample& w : wheels) {
      T_OB = T_OB * SE3(ExpSO3({0, 0, w.dyaw_rad}), {w.dx_m, w.dy_m, 0});
    }
    return T_OB;
  };
  EXPECT_NEAR(encoders->calibration.wheel.track_width_m, 0.23, 1e-12);
  const SE3 difference = end(odometry->wheel).inverse() * end(encoders->wheel);
  EXPECT_LT(difference.translation().norm(), 0.02);
  EXPECT_LT(LogSO3(difference.rotation()).norm(), 0.02);
  CheckImu({}, *encoders);
  EXPECT_THAT(AllText(encoders->warnings), testing::Not(HasSubstr("IMU: ")));
  ExpectGoodLog(*encoders);
}

// Odometry of real robots, 190 m to 1.9 km, whose stamps partly repeat: no way may be lost by that.
TEST_F(Dataset, CarmenOdometryKeepsItsWay) {
  for (const char* name : {"acapulco", "aces", "fhw", "intel"}) {
    GW_FIND_OR_SKIP(source, std::string("carmen_odometry/") + name);
    SCOPED_TRACE(name);
    OdometryOptions options;
    options.ground_truth = source / "laser_pose.txt";
    const auto recording = ReadOdometry(source / "odom_raw.txt", options);
    ASSERT_TRUE(recording) << recording.error().message;
    std::vector<std::string> warnings;
    const auto poses = ReadTumTrajectory(source / "odom_raw.txt", "odometry", warnings);
    ASSERT_TRUE(poses);
    SE3 T_OB = poses->front().T;
    for (const WheelSample& w : recording->wheel) {
      T_OB = T_OB * SE3(ExpSO3({0, 0, w.dyaw_rad}), {w.dx_m, w.dy_m, 0});
    }
    EXPECT_LT((T_OB.inverse() * poses->back().T).Log().norm(), 1e-3);
    EXPECT_FALSE(recording->ground_truth.empty());
  }
}

}  // namespace
}  // namespace gw::importer

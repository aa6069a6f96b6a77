// Tests with unplugged, broken and dead cameras, and of the calibration that a camera stores.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/loader.h"
#include "drivers/camera/device/write_calibration.h"
#include "drivers/camera/test/camera_rig.h"

namespace gw::camera {
namespace {

using testing::HasSubstr;

TEST(CameraRecovery, UnpluggedInMidStreamAndPluggedIn) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Run(3);
  const size_t before = rig.frames.size();
  ASSERT_GT(before, 60U);
  rig.Unplug();
  rig.Run(10);
  EXPECT_LE(rig.frames.size(), before + 1);
  EXPECT_EQ(rig.health.state, HealthState::kFailed);
  EXPECT_THAT(rig.health.message, HasSubstr("plug it in"));
  EXPECT_EQ(rig.camera().open_nodes(), 0) << "so that it comes back under its old name";
  EXPECT_EQ(rig.camera().mapped(), 0);
  rig.Plug();
  rig.Run(4);
  EXPECT_GT(rig.frames.size(), before + 60);
  EXPECT_EQ(rig.frames.back().frame.seq, static_cast<int64_t>(rig.frames.size()))
      << "the sequence goes on";
  EXPECT_NEAR(rig.TimeErrorMs(rig.frames.back()), 0, 1);
  EXPECT_GT(rig.imu.back().utime, rig.frames.back().frame.utime - Milliseconds(100));
  EXPECT_EQ(rig.health.state, HealthState::kOk) << rig.health.message;
  EXPECT_EQ(rig.counter("camera.restarts"), 0) << "absence is no failure";
  EXPECT_TRUE(rig.resets.empty());
}

TEST(CameraRecovery, AbsentAtTheStart) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Unplug();
  rig.Run(30);
  EXPECT_EQ(rig.health.state, HealthState::kFailed);
  EXPECT_THAT(rig.health.message, HasSubstr("no RealSense D435i found"));
  EXPECT_FALSE(rig.node().gave_up());
  rig.Plug();
  rig.Run(3);
  EXPECT_GT(rig.frames.size(), 40U);
}

TEST(CameraRecovery, ErrorOfTheStreamRestartsIt) {
  CameraRig rig(ConfigForTest(CameraKind::kRgbd));
  rig.Run(3);
  const size_t before = rig.frames.size();
  rig.camera().FailStream();
  rig.Run(3);
  EXPECT_EQ(rig.counter("camera.restarts"), 1);
  EXPECT_EQ(rig.counter("camera.opens"), 2);
  EXPECT_GT(rig.frames.size(), before + 40);
  EXPECT_TRUE(rig.resets.empty());
}

TEST(CameraRecovery, StartThatFailsOnceIsRepeated) {
  CameraRig rig(ConfigForTest(CameraKind::kRgbd));
  rig.camera().RefuseStart(1);
  rig.Run(3);
  EXPECT_GT(rig.frames.size(), 30U);
  EXPECT_EQ(rig.counter("camera.restarts"), 1);
  EXPECT_EQ(rig.camera().mapped(), 4 * static_cast<int>(VideoNode::kBuffers));
}

TEST(CameraRecovery, SilentStreamIsRestartedThenResetOnTheUsb) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Run(3);
  const size_t before = rig.frames.size();
  rig.camera().SetSilent(true);
  rig.on_reset = [&rig] { rig.camera().SetSilent(false); };
  rig.Run(20);
  EXPECT_EQ(rig.resets, (std::vector<std::pair<int, int>>{{2, 7}}));
  EXPECT_EQ(rig.counter("camera.restarts"), 3);
  EXPECT_EQ(rig.counter("camera.usb_resets"), 1);
  EXPECT_GT(rig.frames.size(), before + 60);
  EXPECT_EQ(rig.health.state, HealthState::kOk) << rig.health.message;
}

TEST(CameraRecovery, GivesUpLoudly) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.camera().SetSilent(true);
  rig.Run(60);
  ASSERT_TRUE(rig.node().gave_up());
  EXPECT_THAT(*rig.node().gave_up(), HasSubstr("another port or cable"));
  EXPECT_EQ(rig.health.state, HealthState::kFailed);
  EXPECT_EQ(rig.health.message, *rig.node().gave_up());
  EXPECT_EQ(rig.resets.size(), 2U);
  EXPECT_EQ(rig.camera().open_nodes(), 0);
}

TEST(CameraCalibrationFile, HoldsWhatTheCameraStores) {
  for (const CameraKind kind : {CameraKind::kStereo, CameraKind::kRgbd}) {
    const RobotConfig config = ConfigForTest(kind);
    EmulatedCameraConfig emulated;
    emulated.calibration.baseline_mm = 50.125;
    CameraRig rig(config, emulated);
    const auto found = FindCamera(CameraSource::kRealsense, "auto", rig.system().roots());
    ASSERT_TRUE(found);
    auto camera =
        Camera::Open(&rig.camera(), *found, config.drivers.camera, config.calibration.camera);
    ASSERT_TRUE(camera) << camera.error().message;
    const auto calibration = (*camera)->ReadCalibration();
    ASSERT_TRUE(calibration) << calibration.error().message;
    const std::string path = testing::TempDir() + "/calibrated.yaml";
    ASSERT_TRUE(WriteCalibratedConfig(WithCalibration(config, *calibration), path));
    const auto loaded = LoadRobotConfig(path);
    ASSERT_TRUE(loaded) << loaded.error().message;
    const CameraCalibration& written = loaded->calibration.camera;
    EXPECT_EQ(written.left.fx, 385);
    EXPECT_EQ(written.left.fy, 385.5);
    EXPECT_EQ(written.left.cx, 320.25);
    EXPECT_FALSE(written.left.distorted());
    if (kind == CameraKind::kStereo) {
      EXPECT_EQ(written.right.cy, 239.75);
      EXPECT_NEAR(written.T_C0C1.translation().x(), 0.050125, 1e-9);
    } else {
      EXPECT_NEAR(written.depth_baseline_m, 0.050125, 1e-9);
    }
    EXPECT_EQ(loaded->drivers.camera.transport_delay_ms, 5);
    EXPECT_FALSE(WriteCalibratedConfig(config, "/no/such/folder/file.yaml"));
  }
}

}  // namespace
}  // namespace gw::camera

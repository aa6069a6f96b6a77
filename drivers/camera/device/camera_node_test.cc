// Tests of what is published, and of what HEALTH says, with an emulated D435i.
#include "drivers/camera/device/camera_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drivers/camera/device/sysfs.h"
#include "drivers/camera/test/camera_rig.h"

namespace gw::camera {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::vector<std::string> Warnings(CameraRig& rig) {
  return rig.node().Warnings();
}

// This runs for more than a minute around the wrap of the camera's clock.
TEST(CameraNode, StereoPairsWithTheTimeOfMidExposureAcrossTheWrap) {
  EmulatedCameraConfig emulated;
  emulated.first_pts_us = UINT32_MAX - 4'000'000;
  emulated.clock_ppm = 50;
  CameraRig rig(ConfigForTest(CameraKind::kStereo), emulated);
  rig.Run(8);
  ASSERT_GT(rig.frames.size(), 210U);
  double worst_ms = 0;
  for (size_t i = 0; i < rig.frames.size(); ++i) {
    const CameraFrame& frame = rig.frames[i].frame;
    ASSERT_EQ(frame.seq, static_cast<int64_t>(i) + 1);
    ASSERT_FALSE(frame.right.empty());
    ASSERT_TRUE(frame.depth.empty());
    ASSERT_EQ(frame.right.data[0], static_cast<uint8_t>(frame.left.data[0] + 100));
    ASSERT_EQ(frame.left.data[5], 120);
    ASSERT_EQ(frame.right.data[25], 80);
    if (i > 30) worst_ms = std::max(worst_ms, std::abs(rig.TimeErrorMs(rig.frames[i])));
  }
  EXPECT_LT(worst_ms, 1.0);
  std::printf("worst time %.3f ms\n", worst_ms);
  EXPECT_EQ(rig.health.state, HealthState::kOk) << rig.health.message;
  EXPECT_EQ(rig.counter("camera.clock_restarts"), 0);
  EXPECT_EQ(rig.counter("camera.lost"), 0);
  EXPECT_EQ(rig.counter("camera.without_metadata"), 0);
}

TEST(CameraNode, WhichOfTwoCamerasIsForTheConfigurationToSay) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.system().Plug({.port = "2-2", .serial = "b", .first_node = 6, .first_iio = 2});
  rig.Run(0.1);
  ASSERT_TRUE(rig.node().absent());
  EXPECT_EQ(rig.node().absent()->code, ErrorCode::kBadConfig);
  EXPECT_FALSE(rig.node().streaming());
}

TEST(CameraNode, GreyAndDepthOfOneInstant) {
  CameraRig rig(ConfigForTest(CameraKind::kRgbd));
  rig.Run(2);
  ASSERT_GT(rig.frames.size(), 30U);
  for (const auto& message : rig.frames) {
    const CameraFrame& frame = message.frame;
    ASSERT_TRUE(frame.right.empty());
    ASSERT_EQ(frame.depth.format, PixelFormat::kDepth16);
    EXPECT_EQ(frame.depth.data[0], frame.left.data[0]) << "numbers of the frames";
    EXPECT_EQ(frame.depth.data[2] | frame.depth.data[3] << 8, 2000);
    EXPECT_EQ(frame.emitter, EmitterState::kOff);
  }
  EXPECT_EQ(rig.health.state, HealthState::kOk) << rig.health.message;
}

// The kernel of Debian 12 offers the header alone: device time, but no exposure.
TEST(CameraNode, HeaderOnlyMetadata) {
  EmulatedCameraConfig emulated;
  emulated.d4xx_metadata = false;
  RobotConfig config = ConfigForTest(CameraKind::kStereo);
  config.drivers.camera.exposure = ExposureMode::kFixed;
  config.drivers.camera.exposure_us = 4000;
  CameraRig rig(config, emulated);
  rig.Run(3);
  ASSERT_GT(rig.frames.size(), 60U);
  EXPECT_EQ(rig.frames.back().frame.exposure_us, 4000);
  EXPECT_NEAR(rig.TimeErrorMs(rig.frames.back()), 0, 0.5);
  EXPECT_THAT(rig.log, HasSubstr("times in metadata"));
}

TEST(CameraNode, LostAndBadImagesAreCountedAndNotPublished) {
  CameraRig rig(ConfigForTest(CameraKind::kRgbd));
  rig.Run(2);
  rig.camera().LoseFrames(3);
  rig.Run(1);
  rig.camera().DamageFrames(2);
  rig.Run(1);
  rig.camera().ShortenFrames(1);
  rig.Run(1);
  rig.camera().LoseMetadata(1);
  rig.Run(2);
  EXPECT_EQ(rig.counter("camera.lost"), 3);
  EXPECT_EQ(rig.counter("camera.bad"), 3);
  EXPECT_EQ(rig.counter("camera.depth_lost"), 3);
  EXPECT_EQ(rig.counter("camera.depth_bad"), 3);
  EXPECT_EQ(rig.counter("camera.without_metadata"), 1);
  // The other images came, each once and in order, the one without metadata too and at its time.
  std::vector<int> missing;
  for (size_t i = 1; i < rig.frames.size(); ++i) {
    const int step = static_cast<uint8_t>(rig.frames[i].frame.left.data[0] -
                                          rig.frames[i - 1].frame.left.data[0]);
    ASSERT_GE(step, 1);
    if (step > 1) missing.push_back(step - 1);
    EXPECT_NEAR(rig.TimeErrorMs(rig.frames[i]), 0, 4);
  }
  EXPECT_EQ(missing, (std::vector<int>{3, 2, 1}));
}

TEST(CameraNode, ManyLostImagesAreAWarning) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Run(2);
  EXPECT_THAT(Warnings(rig), IsEmpty());
  for (int i = 0; i < 10; ++i) {
    rig.camera().LoseFrames(3);
    rig.Run(0.5);
  }
  EXPECT_THAT(Warnings(rig), Contains(StartsWith("lost:")));
  EXPECT_EQ(rig.health.state, HealthState::kDegraded);
}

TEST(CameraNode, ControlsAreSet) {
  RobotConfig config = ConfigForTest(CameraKind::kStereo);
  CameraRig rig(config);
  rig.camera().RefuseUnitControls(5);  // the camera is busy at first
  rig.Run(3);
  EXPECT_FALSE(rig.camera().emitter_on());
  EXPECT_FALSE(rig.camera().alternating());
  EXPECT_FALSE(rig.camera().auto_exposure());
  EXPECT_LE(rig.camera().exposure_us(), 8000U);
  EXPECT_GE(rig.camera().pauses(), 5);
  EXPECT_GT(rig.frames.size(), 60U);

  config.drivers.camera.emitter = EmitterMode::kOn;
  config.drivers.camera.laser_power_mw = 100;
  config.drivers.camera.exposure = ExposureMode::kFixed;
  config.drivers.camera.exposure_us = 5000;
  config.drivers.camera.gain = 64;
  CameraRig lit(config);
  lit.Run(1);
  EXPECT_TRUE(lit.camera().emitter_on());
  EXPECT_EQ(lit.camera().laser_power_mw(), 90U);  // the power has steps of 30 mW
  EXPECT_EQ(lit.camera().exposure_us(), 5000U);
  EXPECT_EQ(lit.camera().gain(), 64);

  config.drivers.camera.exposure = ExposureMode::kCamera;
  CameraRig automatic(config);
  automatic.Run(1);
  EXPECT_TRUE(automatic.camera().auto_exposure());
}

TEST(CameraNode, CappedExposureFollowsTheLight) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.scene.dark = true;
  rig.Run(6);
  EXPECT_EQ(rig.camera().exposure_us(), 8000U);
  EXPECT_EQ(rig.camera().gain(), 248);
}

// Dots are in every other image; what is published has none.
TEST(CameraNode, AlternatingProjectorPublishesUnlitImages) {
  RobotConfig config = ConfigForTest(CameraKind::kRgbd);
  config.drivers.camera.emitter = EmitterMode::kAlternating;
  CameraRig rig(config);
  rig.Run(4);
  EXPECT_TRUE(rig.camera().alternating());
  ASSERT_GT(rig.frames.size(), 45U);
  for (const auto& message : rig.frames) {
    EXPECT_EQ(message.frame.left.data[0] % 2, 0);
    EXPECT_EQ(message.frame.emitter, EmitterState::kOff);
  }
  EXPECT_GE(rig.counter("camera.lit"), 45);
  EXPECT_THAT(Warnings(rig), IsEmpty());

  EmulatedCameraConfig old;
  old.firmware = {5, 10, 3, 0};
  CameraRig refused(config, old);
  refused.Run(1);
  EXPECT_THAT(refused.health.message, HasSubstr("cannot alternate"));
}

TEST(CameraNode, DotsAreSeenWhateverTheCameraSays) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Run(3);
  EXPECT_THAT(Warnings(rig), IsEmpty());
  rig.scene.foreign_projector = true;
  rig.Run(3);
  EXPECT_FALSE(rig.camera().emitter_on());
  EXPECT_THAT(Warnings(rig), Contains(StartsWith("emitter:")));
  EXPECT_EQ(rig.health.state, HealthState::kDegraded);
  EXPECT_EQ(rig.frames.back().frame.emitter, EmitterState::kOn);
}

TEST(CameraNode, NamedWarnings) {
  EmulatedCameraConfig emulated;
  emulated.has_y8i = false;
  CameraRig rig(ConfigForTest(CameraKind::kRgbd), emulated, {.port = "1-1", .speed_mbps = 480});
  rig.scene.dark = true;
  rig.motion_clock_error_us = 350'000'000;
  rig.camera().SetDeviceError(2);
  rig.Run(4);
  EXPECT_THAT(Warnings(rig), AllOf(Contains(StartsWith("usb2:")), Contains(StartsWith("dark:")),
                                   Contains(StartsWith("skew:")), Contains(StartsWith("device:"))));
  EXPECT_THAT(rig.health.message, HasSubstr("too hot"));
}

TEST(CameraNode, OneEyedCameraIsRefusedForStereo) {
  EmulatedCameraConfig emulated;
  emulated.has_y8i = false;
  CameraRig rig(ConfigForTest(CameraKind::kStereo), emulated);
  rig.Run(1);
  EXPECT_TRUE(rig.frames.empty());
  EXPECT_EQ(rig.health.state, HealthState::kFailed);
  EXPECT_THAT(rig.health.message, HasSubstr("one eye only"));
}

TEST(CameraNode, ModeThatTheCameraDoesNotHaveIsNamed) {
  RobotConfig config = ConfigForTest(CameraKind::kStereo);
  config.calibration.camera.width = 800;
  CameraRig rig(config);
  rig.Run(1);
  EXPECT_THAT(rig.health.message, AllOf(HasSubstr("wanted Y8I  800x480 at 30 Hz"),
                                        HasSubstr("gives Y8I  640x480 at 30 Hz")));
}

TEST(CameraNode, ImuScaleAxesAndRate) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Run(3);
  ASSERT_GT(rig.imu.size(), 550U);
  const double deg = std::numbers::pi / 180;
  for (size_t i = 1; i < rig.imu.size(); ++i) {
    const ImuSample& sample = rig.imu[i];
    EXPECT_EQ(sample.seq, rig.imu[i - 1].seq + 1);
    EXPECT_EQ((sample.utime - rig.imu[i - 1].utime).us, 5000);
    ASSERT_TRUE(sample.has_accel);
    // Firmware 5.16: 0.0001 deg/s a step; camera axes are (-x, y, -z) of the sensor.
    EXPECT_TRUE(sample.w_I_rad_s.isApprox(Eigen::Vector3d(-0.1, 0.2, -0.3) * deg));
    EXPECT_TRUE(sample.a_I_m_s2.isApprox(Eigen::Vector3d(-0.01, -1, -0.02) * 9.80665));
  }
  // The sample has the kernel's time, 1 ms before it could be read.
  EXPECT_NEAR((rig.imu.back().utime - Utime{CameraRig::kOffsetUs}).seconds(), 4.0, 0.01);
  const auto set = [&](int device, const std::string& file) {
    return ReadSysfs(rig.system().IioFolder(device) / file);
  };
  EXPECT_EQ(set(0, "in_accel_sampling_frequency"), "3");    // 250 Hz
  EXPECT_EQ(set(1, "in_anglvel_sampling_frequency"), "2");  // 200 Hz
  EXPECT_EQ(set(0, "trigger/current_trigger"), "accel_3d-dev0");
  EXPECT_EQ(set(1, "trigger/current_trigger"), "gyro_3d-dev1");
  EXPECT_EQ(set(1, "current_timestamp_clock"), "monotonic");
  EXPECT_EQ(set(1, "scan_elements/in_anglvel_z_en"), "1");
  EXPECT_EQ(set(1, "buffer/enable"), "1");
}

TEST(CameraNode, SilentImuIsReportedAndOpenedAgain) {
  CameraRig rig(ConfigForTest(CameraKind::kStereo));
  rig.Run(2);
  rig.motion_on = false;
  rig.Run(1.5);
  EXPECT_THAT(Warnings(rig), Contains(StartsWith("imu:")));
  const size_t before = rig.imu.size();
  rig.motion_on = true;
  rig.Run(4);
  EXPECT_GT(rig.imu.size(), before + 300);
  EXPECT_THAT(Warnings(rig), IsEmpty());
}

}  // namespace
}  // namespace gw::camera

#include "drivers/camera/device/find_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "test/emulators/camera/fake_system.h"

namespace gw::camera {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

class FindCameraTest : public testing::Test {
 protected:
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("find_camera_" + std::to_string(::getpid()));
  FakeSystem system_{folder_};

  Result<FoundCamera> Find(const std::string& device,
                           CameraSource source = CameraSource::kRealsense) const {
    return FindCamera(source, device, system_.roots());
  }
};

TEST_F(FindCameraTest, NodesInterfacesSpeedAndMotionSensors) {
  system_.AddVirtual(0, "vivid-000-vid-cap");
  system_.Plug({.port = "2-1", .first_node = 2, .first_iio = 3});
  const auto found = Find("auto");
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->serial, "a1b2c3d4e5f6");
  EXPECT_EQ(found->bus, 2);
  EXPECT_EQ(found->address, 7);
  EXPECT_FALSE(found->usb2());
  ASSERT_EQ(found->nodes.size(), 6U);
  EXPECT_THAT(found->nodes[0].path, EndsWith("/dev/video2"));
  EXPECT_EQ(found->nodes[3].interface_number, 0);
  EXPECT_EQ(found->nodes[4].interface_number, 3);
  EXPECT_THAT(found->accel, EndsWith("iio:device3"));
  EXPECT_THAT(found->gyro, EndsWith("iio:device4"));
}

TEST_F(FindCameraTest, NodesAreSortedByNumberNotByText) {
  system_.Plug({.port = "2-1", .first_node = 8});
  const auto found = Find("auto");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->nodes.front().number, 8);
  EXPECT_EQ(found->nodes.back().number, 13);
}

TEST_F(FindCameraTest, Usb2Link) {
  system_.Plug({.port = "1-1", .speed_mbps = 480});
  EXPECT_TRUE(Find("auto")->usb2());
}

TEST_F(FindCameraTest, SerialNumberChoosesAndSurvivesAnotherPlace) {
  const FakeSystem::UsbCamera b{.port = "2-2", .serial = "b", .first_node = 6, .first_iio = 2};
  system_.Plug({.port = "2-1", .serial = "a"});
  system_.Plug(b);
  EXPECT_EQ(Find("auto").error().code, ErrorCode::kBadConfig);
  EXPECT_THAT(Find("auto").error().message, HasSubstr("a (Intel"));
  EXPECT_EQ(Find("b")->nodes.front().number, 6);
  system_.Unplug(b);
  EXPECT_EQ(Find("b").error().code, ErrorCode::kNotFound);
  EXPECT_THAT(Find("b").error().message, HasSubstr("plugged in: a (Intel"));
  EXPECT_THAT(Find("b").error().message, EndsWith("correct drivers.camera.device"));
  FakeSystem::UsbCamera elsewhere = b;
  elsewhere.port = "4-3";
  elsewhere.first_node = 20;
  system_.Plug(elsewhere);
  EXPECT_EQ(Find("b")->nodes.front().number, 20);
}

TEST_F(FindCameraTest, CameraWithoutItsDriverIsToldFromNoCamera) {
  const FakeSystem::UsbCamera camera{.port = "2-1"};
  EXPECT_THAT(Find("auto").error().message, EndsWith("plug it in"));
  system_.Plug(camera);
  system_.UnloadVideoDriver(camera);
  EXPECT_EQ(Find("auto").error().code, ErrorCode::kNotFound);
  EXPECT_THAT(Find("auto").error().message, HasSubstr("a1b2c3d4e5f6 is on the USB"));
  EXPECT_THAT(Find("auto").error().message, HasSubstr("modprobe uvcvideo"));
  EXPECT_THAT(Find("auto", CameraSource::kUvc).error().message, HasSubstr("no camera found"));
}

TEST_F(FindCameraTest, OtherCamerasAreNoRealsense) {
  EXPECT_THAT(Find("auto").error().message, HasSubstr("none is plugged in"));
  system_.Plug({.port = "1-1", .vendor = "046d", .product = "0825", .serial = "webcam"});
  EXPECT_EQ(Find("auto").error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(Find("auto", CameraSource::kUvc));
  EXPECT_TRUE(Find("webcam", CameraSource::kUvc));
}

TEST_F(FindCameraTest, GenericCameraByPath) {
  system_.AddVirtual(0, "vivid-000-vid-cap");
  system_.AddVirtual(1, "vivid-001-vid-cap");
  EXPECT_EQ(Find("auto", CameraSource::kUvc).error().code, ErrorCode::kBadConfig);
  const auto found = Find(system_.roots().dev + "/video1", CameraSource::kUvc);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->product, "vivid-001-vid-cap");
  EXPECT_EQ(found->bus, 0);
}

}  // namespace
}  // namespace gw::camera

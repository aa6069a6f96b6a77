#include <gtest/gtest.h>

#include "drivers/camera/protocol/depth_unit_controls.h"

namespace gw::camera {
namespace {

using Bytes = std::vector<uint8_t>;

TEST(DepthUnitControls, BytesOfEachControl) {
  EXPECT_EQ(SetEmitter(false), (UnitControl{static_cast<Selector>(2), {0}}));
  EXPECT_EQ(SetEmitter(true), (UnitControl{static_cast<Selector>(2), {1}}));
  EXPECT_EQ(SetExposureUs(8500), (UnitControl{static_cast<Selector>(3), {0x34, 0x21, 0, 0}}));
  EXPECT_EQ(SetLaserPowerMw(360), (UnitControl{static_cast<Selector>(4), {0x68, 0x01}}));
  EXPECT_EQ(SetAutoExposure(true), (UnitControl{static_cast<Selector>(11), {1}}));
}

TEST(DepthUnitControls, TemperaturesOnlyWhenValid) {
  const auto both = ParseTemperatures(Bytes{1, 1, 41, 0xFB});
  ASSERT_TRUE(both);
  EXPECT_EQ(both->projector_c, 41);
  EXPECT_EQ(both->asic_c, -5);
  EXPECT_FALSE(ParseTemperatures(Bytes{0, 1, 41, 42})->projector_c);
  EXPECT_FALSE(ParseTemperatures(Bytes{1, 1, 41}));
}

TEST(DepthUnitControls, WishesBecomeWhatTheCameraCan) {
  EXPECT_EQ(ClampToSteps(150, 0, 360, 30), 150U);
  EXPECT_EQ(ClampToSteps(100, 0, 360, 30), 90U);
  EXPECT_EQ(ClampToSteps(999, 0, 360, 30), 360U);
  EXPECT_EQ(ClampToSteps(0, 1, 165000, 0), 1U);
  EXPECT_EQ(ClampToSteps(8500, 20, 165000, 20), 8500U);
}

TEST(DepthUnitControls, ErrorsHaveWords) {
  EXPECT_EQ(DeviceErrorText(0), "");
  EXPECT_NE(DeviceErrorText(13).find("overflow"), std::string::npos);
  EXPECT_EQ(DeviceErrorText(99), "error 99");
}

}  // namespace
}  // namespace gw::camera

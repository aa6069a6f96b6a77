#include "grid/core/look_taker.h"

#include <gtest/gtest.h>

#include "grid/core/test_scene.h"

namespace gw::grid {
namespace {

// Of a second of images at 30 Hz whose stamps are early and late in turn: how many are looked at.
int LooksInASecond(Calibration calibration, const GridConfig& config) {
  calibration.camera.rate_hz = 30;
  LookTaker looks(*MakeCameraGeometry(calibration), config);
  int taken = 0;
  for (int i = 0; i < 30; ++i) {
    CameraFrame frame;  // without an image: refused, and counted as looked at
    frame.utime = Utime{1'000'000 + 33'333 * i + (i % 2 == 0 ? 8'000 : -8'000)};
    if (!looks.Due(frame.utime)) continue;
    EXPECT_FALSE(looks.Look(frame, 1));
    ++taken;
  }
  return taken;
}

TEST(LookTaker, AStereoPairIsMatchedHalfAsOftenAsDepthIsRead) {
  EXPECT_EQ(LooksInASecond(SceneCalibration(), {}), 10);
  EXPECT_EQ(LooksInASecond(StereoCalibration(), {}), 5);
}

TEST(LookTaker, TakesTheRateThatIsAskedFor) {
  GridConfig config;
  config.rate_hz = 15;
  EXPECT_EQ(LooksInASecond(SceneCalibration(), config), 15);
  EXPECT_EQ(LooksInASecond(StereoCalibration(), config), 15);
}

}  // namespace
}  // namespace gw::grid

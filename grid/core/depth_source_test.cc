#include "grid/core/depth_source.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "grid/core/test_scene.h"

namespace gw::grid {
namespace {

constexpr int kWidth = 640, kHeight = 480;

CameraGeometry StereoGeometry() {
  return *MakeCameraGeometry(StereoCalibration());
}

// A wall that fills the view, `disparity` px away; its right half is blank but for noise.
struct Pair {
  explicit Pair(int disparity) {
    CounterRng rng(1, 2, 3);
    std::vector<uint8_t> texture(static_cast<size_t>(kWidth + 64) * kHeight);
    for (size_t i = 0; i < texture.size(); ++i) {
      const size_t x = i % (kWidth + 64);
      const bool blank = x > kWidth / 2;
      const size_t row = i / (kWidth + 64) / 8, column = x / 3;
      texture[i] = blank ? static_cast<uint8_t>(100)
                         : static_cast<uint8_t>(60 + CounterRng(7, row, column).Below(120));
    }
    const auto cut = [&](int shift) {
      std::vector<uint8_t> image;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          image.push_back(static_cast<uint8_t>(
              texture[static_cast<size_t>(y) * (kWidth + 64) + static_cast<size_t>(x + shift)] +
              rng.Below(2)));
        }
      }
      return image;
    };
    left = cut(0);
    right = cut(disparity);
    frame.left = {left.data(), kWidth, kHeight, kWidth, PixelFormat::kGray8};
    frame.right = {right.data(), kWidth, kHeight, kWidth, PixelFormat::kGray8};
  }
  std::vector<uint8_t> left, right;
  CameraFrame frame;
};

TEST(DepthSource, StereoMeasuresTextureAndRefusesWhatIsBlank) {
  const CameraGeometry geometry = StereoGeometry();
  const auto source = MakeDepthSource(geometry, {});
  const Pair pair(11);
  DepthImage depth;
  ASSERT_TRUE(source->Measure(pair.frame, &depth));
  const DepthRays& rays = source->rays();
  ASSERT_EQ(depth.size(), static_cast<size_t>(rays.width) * static_cast<size_t>(rays.height));
  const double expected = geometry.rectified.bf() / 11;
  int good = 0, all = 0, blank = 0;
  for (int v = 10; v < rays.height - 10; ++v) {
    for (int u = 100; u < rays.width; ++u) {
      const float z =
          depth[static_cast<size_t>(v) * static_cast<size_t>(rays.width) + static_cast<size_t>(u)];
      if (u < 300) {
        ++all;
        good += std::abs(z - expected) < 0.1;
      } else if (u > 340) {
        blank += z > 0;
      }
    }
  }
  EXPECT_GT(good, 0.9 * all);
  EXPECT_EQ(blank, 0);
}

TEST(DepthSource, RgbdKeepsWhatIsFarEnoughAway) {
  const auto source = MakeDepthSource(SceneGeometry(), {});
  std::vector<uint16_t> raw(static_cast<size_t>(kWidth) * kHeight, 1500);
  raw[0] = 0;
  raw[2] = 100;  // nearer than depth_min_m
  CameraFrame frame;
  frame.depth = {reinterpret_cast<const uint8_t*>(raw.data()), kWidth, kHeight, 2 * kWidth,
                 PixelFormat::kDepth16};
  DepthImage depth;
  ASSERT_TRUE(source->Measure(frame, &depth));
  EXPECT_EQ(depth[0], 0);
  EXPECT_EQ(depth[1], 0);
  EXPECT_FLOAT_EQ(depth[2], 1.5f);
}

TEST(DepthSource, TheNoiseOfADepthImageIsThatOfItsSensor) {
  Calibration calibration = SceneCalibration();
  const auto sigma_of = [&] {
    return MakeDepthSource(*MakeCameraGeometry(calibration), {})->rays().sigma_per_m2;
  };
  const double before = sigma_of();
  calibration.camera.disparity_sigma_px *= 3;  // a Kinect
  EXPECT_NEAR(sigma_of(), 3 * before, 1e-12);
  GridConfig coarse;
  coarse.disparity_sigma_px *= 2;  // of matched pairs
  EXPECT_NEAR(MakeDepthSource(StereoGeometry(), coarse)->rays().sigma_per_m2,
              2 * MakeDepthSource(StereoGeometry(), {})->rays().sigma_per_m2, 1e-12);
}

TEST(DepthSource, AnImageOfAnotherKindOrSizeIsRefused) {
  const auto rgbd = MakeDepthSource(SceneGeometry(), {});
  const auto stereo = MakeDepthSource(StereoGeometry(), {});
  Pair pair(5);
  DepthImage depth;
  EXPECT_FALSE(rgbd->Measure(pair.frame, &depth));
  EXPECT_TRUE(stereo->Measure(pair.frame, &depth));
  pair.frame.right.width = 320;
  EXPECT_FALSE(stereo->Measure(pair.frame, &depth));
  EXPECT_FALSE(stereo->Measure({}, &depth));
}

}  // namespace
}  // namespace gw::grid

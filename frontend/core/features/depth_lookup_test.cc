#include "frontend/core/features/depth_lookup.h"

#include <gtest/gtest.h>

#include <vector>

#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

constexpr int kSide = 16;

class DepthLookupTest : public testing::Test {
 protected:
  void Fill(int x0, int x1, uint16_t value) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = x0; x < x1; ++x)
        pixels_[static_cast<size_t>(y) * kSide + static_cast<size_t>(x)] = value;
    }
  }
  float At(float u, float v) const {
    return lookup_.At({reinterpret_cast<const uint8_t*>(pixels_.data()), kSide, kSide, 2 * kSide,
                       PixelFormat::kDepth16},
                      u, v);
  }
  std::vector<uint16_t> pixels_ = std::vector<uint16_t>(kSide * kSide, 0);
  DepthLookup lookup_{MakeCameraGeometry(TestDepthCalibration(kSide, kSide, 500)).value()};
};

TEST_F(DepthLookupTest, IsTheMeanOnASmoothSurface) {
  Fill(0, 8, 2000);
  Fill(8, 9, 2010);
  Fill(9, kSide, 2020);
  EXPECT_NEAR(At(8.3f, 7.8f), 2.010f, 1e-4f);
}

TEST_F(DepthLookupTest, TakesTheFrontSideOfAnEdge) {
  Fill(0, 8, 1000);
  Fill(8, kSide, 3000);
  EXPECT_NEAR(At(7, 8), 1.0f, 1e-6f);  // six pixels in front
  EXPECT_NEAR(At(9, 8), 3.0f, 1e-6f);  // all behind
}

TEST_F(DepthLookupTest, RefusesWhereTheFrontSideHasTooFewPixels) {
  Fill(0, 8, 1000);
  Fill(8, kSide, 3000);
  EXPECT_LT(At(8, 8), 0);  // three pixels in front: neither side is sure
}

TEST_F(DepthLookupTest, RefusesHolesAndTheRim) {
  EXPECT_LT(At(8, 8), 0);
  Fill(8, 9, 2000);
  EXPECT_LT(At(8, 8), 0);  // three of nine
  Fill(7, 9, 2000);
  EXPECT_NEAR(At(8, 8), 2.0f, 1e-6f);
  Fill(0, kSide, 2000);
  for (const float edge : {-1.0f, 0.0f, kSide - 1.0f, kSide + 3.0f}) {
    EXPECT_LT(At(edge, 8), 0);
    EXPECT_LT(At(8, edge), 0);
  }
}

TEST_F(DepthLookupTest, RefusesDepthsBelowTheCamerasRange) {
  Fill(0, kSide, 299);
  EXPECT_LT(At(8, 8), 0);
  Fill(0, kSide, 301);
  EXPECT_GT(At(8, 8), 0);
}

}  // namespace
}  // namespace gw::frontend

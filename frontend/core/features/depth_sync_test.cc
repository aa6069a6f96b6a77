#include "frontend/core/features/depth_sync.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/core/random.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kRate = 10;    // images per second
constexpr double kUnit = 1e-4;  // m
constexpr double kDistance = 3;

CameraGeometry Geometry() {
  Calibration c = TestDepthCalibration(kWidth, kHeight, 96);
  c.camera.depth_unit_m = kUnit;
  c.camera.depth_baseline_m = 0.05;
  c.camera.disparity_sigma_px = 0.02;
  return MakeCameraGeometry(c).value();
}

// A camera before a wall turns to and fro: its depth changes, pixel by pixel.
class DepthSyncTest : public testing::Test {
 protected:
  // Angle between the axis of the camera and the normal of the wall.
  static double AngleAt(double images) { return 0.3 * std::sin(2 * images / kRate); }
  // Depth of the wall at a column.
  static double DepthAt(double u, double images) {
    const double x = (u - 80) / 96;
    const double a = AngleAt(images);
    return kDistance / (std::cos(a) + x * std::sin(a));
  }

  void Push(const std::vector<uint16_t>& pixels) {
    sync_.Push({static_cast<int64_t>(1e6 * images_ / kRate)},
               {reinterpret_cast<const uint8_t*>(pixels.data()), kWidth, kHeight, 2 * kWidth,
                PixelFormat::kDepth16});
  }

  // Of the camera, since the image before.
  SE3 Moved() const {
    const double turn = AngleAt(images_) - AngleAt(images_ - 1);
    return {Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY())),
            Eigen::Vector3d::Zero()};
  }

  // Images whose depth is late by so many images, with landmarks wherever they were first seen.
  void Drive(int images, double late) {
    for (int k = 0; k < images; ++k) {
      ++images_;
      std::vector<uint16_t> pixels;
      for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
          const double d = geometry_.rectified.bf() / DepthAt(u, images_ - late);
          const double z = geometry_.rectified.bf() / (d + 0.02 * random_.Normal());
          pixels.push_back(static_cast<uint16_t>(std::lround(z / kUnit)));
        }
      }
      Push(pixels);
      std::vector<DepthSync::Sight> sights;
      for (int64_t i = 0; i < 100; ++i) {
        // Landmark i lies on the wall, placed from depth as late as all.
        const double along = -1 + 0.02 * static_cast<double>(i);
        const double a = AngleAt(images_);
        const double z = kDistance * std::cos(a) - along * std::sin(a);
        const double x = kDistance * std::sin(a) + along * std::cos(a);
        const double u = 80 + 96 * x / z;
        if (u < 3 || u > kWidth - 4) continue;
        const double wrong = 1 + 0.02 * std::sin(7 * along);
        sights.push_back({u, 20 + static_cast<double>(i % 80), LandmarkId{i + 1}, wrong * z});
      }
      sync_.Observe(std::move(sights));
    }
  }

  CameraGeometry geometry_ = Geometry();
  DepthSync sync_{geometry_};
  CounterRng random_{1, 0, 0};
  double images_ = 0;
};

TEST_F(DepthSyncTest, DepthOfTheSameInstantIsNotLate) {
  Drive(60, 0);
  EXPECT_NEAR(sync_.Lateness(), 0, 0.05);
}

TEST_F(DepthSyncTest, FindsByHowManyImagesDepthIsLateOrEarly) {
  for (const double late : {1.0, 0.4, -1.0}) {
    sync_ = DepthSync(geometry_);
    Drive(60, late);
    EXPECT_NEAR(sync_.Lateness(), late, 0.15) << late;
    EXPECT_EQ(sync_.IsLate(0.5), late == 1.0);
    EXPECT_EQ(sync_.IsEarly(0.5), late == -1.0);
  }
}

TEST_F(DepthSyncTest, ACameraThatStandsTellsNothing) {
  const double at = images_;
  for (int k = 0; k < 60; ++k) {
    images_ = at;
    Drive(1, 0);
  }
  EXPECT_EQ(sync_.Lateness(), 0);
}

TEST_F(DepthSyncTest, BringsDisparitiesToTheMomentOfTheImage) {
  Drive(3, 1);
  Feature f;
  f.u = 120;
  f.v = 60;
  const double bf = geometry_.rectified.bf();
  f.depth = static_cast<float>(DepthAt(f.u, images_ - 1));
  f.u_right = f.u - static_cast<float>(bf) / f.depth;
  const double wrong = std::abs(bf / f.depth - bf / DepthAt(f.u, images_));
  std::vector<Feature> features = {f};
  sync_.Correct(1, Moved(), &features);
  ASSERT_TRUE(features[0].has_depth());
  EXPECT_LT(std::abs(bf / features[0].depth - bf / DepthAt(f.u, images_)), 0.5 * wrong);
  EXPECT_NEAR(f.u - features[0].u_right, bf / features[0].depth, 1e-3);
}

TEST_F(DepthSyncTest, CorrectsLengthsThatAreScaledLikeTheSensors) {
  Drive(3, 1);
  std::vector<Feature> features(2);
  for (Feature& f : features) {
    f.u = 120;
    f.v = 60;
    f.depth = static_cast<float>(DepthAt(f.u, images_ - 1));
  }
  features[1].depth *= 1.2F;
  for (Feature& f : features)
    f.u_right = f.u - static_cast<float>(geometry_.rectified.bf()) / f.depth;
  sync_.Correct(1, Moved(), &features);
  EXPECT_NEAR(features[1].depth, 1.2F * features[0].depth, 1e-3);
}

TEST_F(DepthSyncTest, WhatHasComeIntoViewHasNoDepth) {
  Drive(3, 1);
  ++images_;
  Push(std::vector<uint16_t>(kWidth * kHeight, static_cast<uint16_t>(std::lround(1 / kUnit))));
  Feature f;
  f.u = 80;
  f.v = 60;
  f.depth = 1;  // somebody before the wall
  f.u_right = f.u - static_cast<float>(geometry_.rectified.bf());
  std::vector<Feature> features = {f};
  sync_.Correct(1, Moved(), &features);
  EXPECT_FALSE(features[0].has_disparity());
}

TEST_F(DepthSyncTest, WithoutDepthBeforeNoneIsBelieved) {
  Drive(1, 1);
  Feature f;
  f.u = 80;
  f.v = 60;
  f.depth = 3;
  f.u_right = 78;
  std::vector<Feature> features = {f};
  sync_.Correct(1, Moved(), &features);
  EXPECT_FALSE(features[0].has_disparity());
}

}  // namespace
}  // namespace gw::frontend

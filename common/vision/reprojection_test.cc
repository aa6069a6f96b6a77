#include "common/vision/reprojection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"

namespace gw {
namespace {

RectifiedCamera TestCamera(double disparity_sigma_px) {
  RectifiedCamera c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 400;
  c.cx = 320;
  c.cy = 240;
  c.baseline_m = 0.05;
  c.disparity_sigma_px = disparity_sigma_px;
  c.depth_min_m = 0.3;
  c.depth_max_m = 4;
  return c;
}

// As an extractor makes it: a depth only within the range, the disparity also beyond.
Feature Seen(const RectifiedCamera& camera, double disparity) {
  Feature f;
  f.u = 300;
  f.v = 200;
  f.level = 3;
  f.u_right = f.u - static_cast<float>(disparity);
  const double z = camera.bf() / disparity;
  if (z <= camera.depth_max_m) f.depth = static_cast<float>(z);
  return f;
}

const Pyramid kPyramid(1.2, 8);

TEST(ObservationOf, AStereoPairHasThePixelsNoiseAndADepthImageThatOfItsSensor) {
  const RectifiedCamera stereo = TestCamera(0);
  const PixelObservation pair = ObservationOf(Seen(stereo, 10), stereo, kPyramid, 2);
  EXPECT_DOUBLE_EQ(pair.inverse_sigma_disparity, pair.inverse_sigma);
  const RectifiedCamera rgbd = TestCamera(0.05);
  const PixelObservation depth = ObservationOf(Seen(rgbd, 10), rgbd, kPyramid, 2);
  EXPECT_NEAR(1 / depth.inverse_sigma_disparity, std::hypot(0.05, kDepthBeside * 10), 1e-6);
  EXPECT_DOUBLE_EQ(depth.inverse_sigma, pair.inverse_sigma);
}

TEST(ObservationOf, WhatIsBesideItsLandmarkSaysNothingOfItsDepth) {
  const RectifiedCamera camera = TestCamera(0);
  const PixelObservation o = ObservationOf(Seen(camera, 8), camera, kPyramid, 2.5);
  const Eigen::Vector3d beside = camera.Unproject(o.u + 3, o.v - 2, camera.bf() / 8);
  const Eigen::Vector3d r = ReprojectionResidual(camera, o, beside);
  EXPECT_NEAR(r[0], 3 * o.inverse_sigma, 1e-9);
  EXPECT_NEAR(r[2], 0, 1e-6);
}

TEST(ObservationOf, NoPointNearTheEndOfTheRangeIsDrawnNearer) {
  const RectifiedCamera camera = TestCamera(0);
  const double disparity = camera.bf() / (0.97 * camera.depth_max_m);
  CounterRng rng(1, 1, 0);
  double sum = 0, chosen = 0;
  int count = 0, close = 0;
  for (int i = 0; i < 4000; ++i) {
    const double measured = disparity + 0.3 * rng.Normal();
    const Feature f = Seen(camera, measured);
    const PixelObservation o = ObservationOf(f, camera, kPyramid, camera.bf() / disparity);
    if (o.has_depth) {
      sum += o.disparity - disparity;
      ++count;
    }
    if (f.has_depth()) {
      chosen += measured - disparity;
      ++close;
    }
  }
  EXPECT_EQ(count, 4000);
  EXPECT_NEAR(sum / count, 0, 0.015);
  EXPECT_GT(chosen / close, 0.1);  // had the measured depth decided
}

TEST(ObservationOf, ALandmarkBeyondTheRangeHasNoDepth) {
  const RectifiedCamera camera = TestCamera(0);
  EXPECT_FALSE(ObservationOf(Seen(camera, 5.5), camera, kPyramid, 4.2).has_depth);
  Feature without;
  without.u = 10;
  EXPECT_FALSE(ObservationOf(without, camera, kPyramid, 2).has_depth);
}

}  // namespace
}  // namespace gw

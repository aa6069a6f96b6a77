#include "backend/core/bundle/landmark_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "backend/test/world.h"

namespace gw::backend {
namespace {

// Cameras side by side along x, `step_m` apart, that look along z at a point.
std::vector<PosedObservation> Observations(const Eigen::Vector3d& p_W, int n, double step_m,
                                           bool depth) {
  const RectifiedCamera camera = TestCamera();
  std::vector<PosedObservation> out;
  for (int i = 0; i < n; ++i) {
    const SE3 T_CW(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-step_m * i, 0, 0));
    const Eigen::Vector3d p_C = T_CW * p_W;
    const Eigen::Vector2d uv = camera.Project(p_C);
    out.push_back({T_CW, {uv.x(), uv.y(), camera.bf() / p_C.z(), depth}});
  }
  return out;
}

const Eigen::Vector3d kPoint(0.3, -0.2, 4);

TEST(LandmarkFit, FindsThePointFromFarOff) {
  for (const bool depth : {false, true}) {
    const auto observations = Observations(kPoint, 5, 0.2, depth);
    for (const double z : {1.0, 3.0, 8.0}) {
      const LandmarkFit fit = FitLandmark(TestCamera(), observations, {0.5, 0.1, z});
      EXPECT_LT((fit.p_W - kPoint).norm(), 1e-3) << depth << " " << z;
      EXPECT_LT(fit.vagueness, 0.02);
    }
  }
}

TEST(LandmarkFit, OneWrongObservationPullsItByNoMoreThanHubersBound) {
  auto observations = Observations(kPoint, 8, 0.1, true);
  observations[3].pixel.u += 400;
  observations[3].pixel.has_depth = false;
  const LandmarkFit fit = FitLandmark(TestCamera(), observations, kPoint);
  EXPECT_LT((fit.p_W - kPoint).norm(), 0.03);
}

TEST(LandmarkFit, VaguenessIsTheSpreadOverTheDepth) {
  // Two views a baseline b apart know the depth to z^2 / (f b) * sqrt(2) pixels.
  const RectifiedCamera camera = TestCamera();
  const double step = 0.02;
  const LandmarkFit fit = FitLandmark(camera, Observations(kPoint, 2, step, false), kPoint);
  const double expected = std::sqrt(2.0) * kPoint.z() / (camera.fx * step);
  EXPECT_NEAR(fit.vagueness, expected, 0.05 * expected);
}

TEST(LandmarkFit, ADirectionThatNobodySeesIsInfinitelyVague) {
  const auto one = Observations(kPoint, 1, 0.1, false);
  const LandmarkFit ray = FitLandmark(TestCamera(), one, kPoint);
  EXPECT_GT(ray.vagueness, 1e3);
  EXPECT_TRUE(ray.p_W.allFinite());
  const LandmarkFit nothing = FitLandmark(TestCamera(), {}, kPoint);
  EXPECT_TRUE(std::isinf(nothing.vagueness));
  EXPECT_EQ(nothing.p_W, kPoint);
}

TEST(LandmarkFit, BehindACameraItStays) {
  const Eigen::Vector3d behind(0, 0, -1);
  const LandmarkFit fit = FitLandmark(TestCamera(), Observations(kPoint, 3, 0.1, true), behind);
  EXPECT_TRUE(std::isinf(fit.vagueness));
  EXPECT_EQ(fit.p_W, behind);
}

}  // namespace
}  // namespace gw::backend

#include "common/vision/pose_optimizer.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "common/core/random.h"

namespace gw {
namespace {

RectifiedCamera TestCamera() {
  RectifiedCamera c;
  c.width = 640;
  c.height = 480;
  c.fx = 520;
  c.fy = 515;
  c.cx = 318;
  c.cy = 250;
  c.baseline_m = 0.08;
  return c;
}

SE3 RandomPose(CounterRng& rng, double size) {
  Vector6d d;
  for (int i = 0; i < 6; ++i) d[i] = rng.Uniform(-size, size);
  return SE3::Exp(d);
}

// n points in view of T_WC, every third without depth, with unit pixel noise.
std::vector<LandmarkObservation> Observe(const RectifiedCamera& camera, const SE3& T_WC, int n,
                                         double noise_px, CounterRng& rng) {
  std::vector<LandmarkObservation> out;
  for (int i = 0; i < n; ++i) {
    const double depth = rng.Uniform(1, 5);
    const Eigen::Vector3d p_C = camera.Unproject(rng.Uniform(20, 620), rng.Uniform(20, 460), depth);
    const Eigen::Vector2d uv = camera.Project(p_C);
    LandmarkObservation o;
    o.p_W = T_WC * p_C;
    o.pixel.u = uv.x() + noise_px * rng.Normal();
    o.pixel.v = uv.y() + noise_px * rng.Normal();
    o.pixel.has_depth = i % 3 != 0;
    o.pixel.disparity = camera.bf() / depth + noise_px * rng.Normal();
    out.push_back(o);
  }
  return out;
}

TEST(PoseOptimizer, JacobianMatchesCentralDifferences) {
  const RectifiedCamera camera = TestCamera();
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(1, 0, i);
    const SE3 T_WC = RandomPose(rng, 1.0);
    const LandmarkObservation o = Observe(camera, T_WC, 2, 3.0, rng).back();
    const auto residual = [&](const SE3& T) {
      return ReprojectionResidual(camera, o.pixel, T.inverse() * o.p_W);
    };
    const Eigen::Vector3d p_C = T_WC.inverse() * o.p_W;
    const auto J = PoseJacobian(ReprojectionJacobian(camera, o.pixel, p_C), p_C);
    constexpr double kStep = 1e-6;
    for (int c = 0; c < 6; ++c) {
      const Vector6d d = kStep * Vector6d::Unit(c);
      const Eigen::Vector3d slope =
          (residual(T_WC * SE3::Exp(d)) - residual(T_WC * SE3::Exp(-d))) / (2 * kStep);
      EXPECT_LT((slope - J.col(c)).norm(), 1e-4 * (1 + J.col(c).norm()));
    }
  }
}

TEST(PoseOptimizer, FindsThePoseAmongOutliers) {
  const RectifiedCamera camera = TestCamera();
  for (int i = 0; i < 50; ++i) {
    CounterRng rng(2, 0, i);
    const SE3 T_WC = RandomPose(rng, 1.0);
    auto observations = Observe(camera, T_WC, 150, 0.5, rng);
    for (int k = 0; k < 40; ++k) {
      observations[k].pixel.u += rng.Uniform(15, 60);
      observations[k].pixel.v -= rng.Uniform(15, 60);
    }
    const auto result =
        OptimizePose(camera, T_WC * RandomPose(rng, 0.03), observations, std::nullopt);
    EXPECT_LT((T_WC.inverse() * result.T_WC).Log().norm(), 0.01) << "case " << i;
    EXPECT_GE(result.num_inliers, 105);
    for (int k = 0; k < 40; ++k) EXPECT_FALSE(result.inlier[k]);
  }
}

// The covariance is honest when the errors, measured in its own units, have mean square 6.
TEST(PoseOptimizer, InformationPredictsTheError) {
  const RectifiedCamera camera = TestCamera();
  double nees = 0;
  constexpr int kRuns = 300;
  for (int i = 0; i < kRuns; ++i) {
    CounterRng rng(3, 0, i);
    const SE3 T_WC = RandomPose(rng, 1.0);
    const auto observations = Observe(camera, T_WC, 80, 1.0, rng);
    const auto result = OptimizePose(camera, T_WC, observations, std::nullopt);
    const Vector6d error = (T_WC.inverse() * result.T_WC).Log();
    nees += error.dot(result.vision_information * error) / kRuns;
  }
  // 95 % band of the mean of 300 chi-square(6); a little wider above, as 5 % of the inliers are
  // cut.
  EXPECT_GT(nees, 5.6);
  EXPECT_LT(nees, 7.2);
}

TEST(PoseOptimizer, WithoutObservationsTheResultIsExactlyThePrior) {
  CounterRng rng(4, 0, 0);
  const SE3 T_prior = RandomPose(rng, 1.0);
  const PosePrior prior{T_prior, Matrix6d::Identity()};
  const auto result = OptimizePose(TestCamera(), SE3(), {}, prior);
  EXPECT_EQ(result.T_WC.translation(), T_prior.translation());
  EXPECT_EQ(result.T_WC.rotation().coeffs(), T_prior.rotation().coeffs());
}

TEST(PoseOptimizer, PriorPullsMoreTheMoreInformationItHas) {
  const RectifiedCamera camera = TestCamera();
  CounterRng rng(5, 0, 0);
  const SE3 T_WC = RandomPose(rng, 1.0);
  const auto observations = Observe(camera, T_WC, 60, 0.5, rng);
  Vector6d offset;
  offset << 0.01, 0, 0, 0, 0.002, 0;
  double last = INFINITY;
  for (const double information : {1e0, 1e4, 1e6, 1e8, 1e12}) {
    const PosePrior prior{T_WC * SE3::Exp(offset), information * Matrix6d::Identity()};
    const auto result = OptimizePose(camera, T_WC, observations, prior);
    const double distance = (prior.T_WC.inverse() * result.T_WC).Log().norm();
    EXPECT_LT(distance, last);
    last = distance;
  }
  EXPECT_LT(last, 1e-5);
}

TEST(PoseOptimizer, SurvivesPointsBehindTheCamera) {
  const RectifiedCamera camera = TestCamera();
  CounterRng rng(6, 0, 0);
  auto observations = Observe(camera, SE3(), 30, 0.5, rng);
  for (auto& o : observations) o.p_W.z() = -o.p_W.z();
  const auto result = OptimizePose(camera, SE3(), observations, std::nullopt);
  EXPECT_EQ(result.num_inliers, 0);
  EXPECT_TRUE(result.T_WC.IsFinite());
}

}  // namespace
}  // namespace gw

#include "backend/core/dr_edge.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>

#include "backend/core/map.h"
#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

Matrix6d RandomCovariance(CounterRng& rng, double scale) {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A.data()[i] = scale * rng.Normal();
  return A * A.transpose();
}

double SmallestEigenvalue(const Matrix6d& m) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(m).eigenvalues()[0];
}

TEST(LargerCovariance, IsNotBelowEitherOne) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 1, 0);
    const Matrix6d a = RandomCovariance(rng, 1.0) + 1e-3 * Matrix6d::Identity();
    const Matrix6d b = RandomCovariance(rng, rng.Uniform(0.01, 3.0));
    const Matrix6d larger = LargerCovariance(a, b);
    EXPECT_GT(SmallestEigenvalue(larger - a), -1e-9 * larger.norm());
    EXPECT_GT(SmallestEigenvalue(larger - b), -1e-9 * larger.norm());
  }
}

TEST(LargerCovariance, OfOneThatDominatesIsThatOne) {
  CounterRng rng(1, 2, 0);
  const Matrix6d a = RandomCovariance(rng, 1.0) + Matrix6d::Identity();
  EXPECT_LT((LargerCovariance(a, 0.5 * a) - a).norm(), 1e-9 * a.norm());
  EXPECT_LT((LargerCovariance(a, 2.0 * a) - 2.0 * a).norm(), 1e-9 * a.norm());
}

TEST(CameraMotion, IsTheBodysMotionSeenFromTheCamera) {
  const SE3 T_BC = TestCamera().T_BC;
  const SE3 T_WBa(ExpSO3({0.1, 0.2, 0.3}), {1, 2, 3});
  const SE3 T_WBb(ExpSO3({-0.1, 0.1, 0.5}), {1.3, 2.1, 3});
  DrIncrement dr;
  dr.utime_end = Utime{1'000'000};
  dr.T_BaBb = T_WBa.inverse() * T_WBb;
  const DrMotion motion = CameraMotion(dr, T_BC, {});
  const SE3 expected = (T_WBa * T_BC).inverse() * (T_WBb * T_BC);
  EXPECT_LT((motion.T_CaCb.matrix() - expected.matrix()).norm(), 1e-12);
}

TEST(CameraMotion, NominalCovarianceGrowsWithTheNumberOfFramePeriods) {
  DrIncrement dr;  // the filter claims to know it exactly
  dr.utime_end = Utime{500'000};
  const Matrix6d cov = CameraMotion(dr, TestCamera().T_BC, {}).cov;
  EXPECT_NEAR(cov(0, 0), 15 * 0.004 * 0.004, 1e-12);
  EXPECT_NEAR(cov(5, 5), 15 * std::pow(0.1 * std::numbers::pi / 180, 2), 1e-12);
}

// The filter's covariance is moved to the camera by sampling, independent of the adjoint.
TEST(CameraMotion, CarriesTheFiltersCovarianceToTheCamera) {
  const SE3 T_BC = TestCamera().T_BC;
  DrIncrement dr;
  dr.utime_end = Utime{33'333};
  dr.T_BaBb = SE3(ExpSO3({0, 0, 0.2}), {0.3, 0, 0});
  Vector6d sigma;
  sigma << 0.05, 0.04, 0.06, 0.05, 0.04, 0.1;
  dr.cov = sigma.cwiseAbs2().asDiagonal();
  const DrMotion motion = CameraMotion(dr, T_BC, {});
  Matrix6d sampled = Matrix6d::Zero();
  constexpr int kSamples = 20000;
  for (uint64_t i = 0; i < kSamples; ++i) {
    CounterRng rng(3, 4, i);
    Vector6d d;
    for (int k = 0; k < 6; ++k) d[k] = 0.1 * sigma[k] * rng.Normal();  // small: stays linear
    const SE3 T = T_BC.inverse() * dr.T_BaBb * SE3::Exp(d) * T_BC;
    const Vector6d e = (motion.T_CaCb.inverse() * T).Log();
    sampled += e * e.transpose() * 100.0 / kSamples;
  }
  EXPECT_LT((sampled - motion.cov).norm(), 0.05 * motion.cov.norm());
}

TEST(Compose, IsTheMotionOverBothIntervals) {
  const World world({});
  const DrIncrement ab = world.Dr(3);
  const DrIncrement bc = world.Dr(4);
  const DrIncrement ac = Compose(ab, bc);
  EXPECT_EQ(ac.utime_begin, ab.utime_begin);
  EXPECT_EQ(ac.utime_end, bc.utime_end);
  EXPECT_LT((ac.T_BaBb.matrix() - (ab.T_BaBb * bc.T_BaBb).matrix()).norm(), 1e-12);
  // Rotations of the first part move the end by the length of the second.
  EXPECT_GT(ac.cov(1, 1), ab.cov(1, 1) + bc.cov(1, 1));
}

}  // namespace
}  // namespace gw::backend

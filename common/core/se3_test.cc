#include "common/core/se3.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw {
namespace {

Vector6d RandomTangent(CounterRng& rng, double translation, double rotation) {
  Vector6d d;
  for (int i = 0; i < 3; ++i) d[i] = rng.Uniform(-translation, translation);
  for (int i = 3; i < 6; ++i) d[i] = rng.Uniform(-rotation, rotation);
  return d;
}

// Every property is swept over 300 seeded cases from tiny to large rotations.
class Se3Property : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(RotationSize, Se3Property, testing::Values(1e-9, 1e-5, 5e-3, 0.3, 1.7));

TEST_P(Se3Property, LogInvertsExp) {
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(1, 0, i);
    const Vector6d d = RandomTangent(rng, 2.0, GetParam());
    EXPECT_LT((SE3::Exp(d).Log() - d).norm(), 1e-9) << "case " << i;
  }
}

TEST_P(Se3Property, AdjointMovesAPerturbationToTheOtherSide) {
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(2, 0, i);
    const SE3 T = SE3::Exp(RandomTangent(rng, 2.0, GetParam()));
    const Vector6d d = RandomTangent(rng, 0.5, 0.5);
    const SE3 right = T * SE3::Exp(d);
    const SE3 left = SE3::Exp(T.Adjoint() * d) * T;
    EXPECT_LT((right.matrix() - left.matrix()).norm(), 1e-9) << "case " << i;
  }
}

TEST_P(Se3Property, JacobiansMatchCentralDifferences) {
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(3, 0, i);
    const Vector6d a = RandomTangent(rng, 2.0, GetParam());
    const Matrix6d J = RightJacobianSE3(a);
    const Matrix6d Ji = RightJacobianInverseSE3(a);
    EXPECT_LT((J * Ji - Matrix6d::Identity()).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (int c = 0; c < 6; ++c) {
      const Vector6d step = kStep * Vector6d::Unit(c);
      const Vector6d forward = (SE3::Exp(a) * SE3::Exp(step)).Log();
      const Vector6d backward = (SE3::Exp(a) * SE3::Exp(-step)).Log();
      EXPECT_LT(((forward - backward) / (2 * kStep) - Ji.col(c)).norm(), 1e-7) << "case " << i;
    }
  }
}

// Fails when translation and rotation are swapped, or when the perturbation moves to the left.
TEST(Se3Convention, TangentIsTranslationFirstAndOnTheRight) {
  const SE3 T(ExpSO3({0, 0, M_PI / 2}), {1, 2, 3});
  Vector6d d = Vector6d::Zero();
  d[0] = 0.1;  // along B's x, which points along A's y
  const SE3 moved = T * SE3::Exp(d);
  EXPECT_NEAR(moved.translation().x(), 1.0, 1e-12);
  EXPECT_NEAR(moved.translation().y(), 2.1, 1e-12);
  EXPECT_NEAR(LogSO3(T.rotation().conjugate() * moved.rotation()).norm(), 0.0, 1e-12);
}

TEST(Se3, InterpolationMeetsBothEndsAndTheMiddle) {
  const SE3 a(ExpSO3({0.1, 0.2, 0.3}), {1, 0, 0});
  const SE3 b(ExpSO3({-0.4, 0.2, 1.0}), {0, 2, 1});
  EXPECT_LT((Interpolate(a, b, 0).matrix() - a.matrix()).norm(), 1e-12);
  EXPECT_LT((Interpolate(a, b, 1).matrix() - b.matrix()).norm(), 1e-12);
  const SE3 m = Interpolate(a, b, 0.5);
  EXPECT_LT(((a.inverse() * m).Log() - (m.inverse() * b).Log()).norm(), 1e-12);
}

TEST(Se3, APointIsMovedToTheLastBitAsEigenDoes) {
  for (int i = 0; i < 300; ++i) {
    CounterRng rng(3, 0, i);
    const SE3 T = SE3::Exp(RandomTangent(rng, 2.0, 3.0));
    const Eigen::Vector3d point = RandomTangent(rng, 10.0, 0.0).head<3>();
    EXPECT_EQ(T * point, T.rotation() * point + T.translation()) << "case " << i;
  }
}

TEST(SE3, NormalisingTwiceChangesNothing) {
  for (int i = 0; i < 10000; ++i) {
    CounterRng rng(11, 0, i);
    const SE3 once({rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal()}, {0, 0, 0});
    const SE3 twice(once.rotation(), once.translation());
    ASSERT_EQ(twice.rotation().coeffs(), once.rotation().coeffs()) << "case " << i;
    ASSERT_NEAR(once.rotation().norm(), 1.0, 1e-15);
  }
}

}  // namespace
}  // namespace gw

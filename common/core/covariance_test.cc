#include "common/core/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "common/core/random.h"

namespace gw {
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

}  // namespace
}  // namespace gw

#include "tools/lab/calibrate/allan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"

namespace gw::calibrate {
namespace {

constexpr double kDt = 0.005;

// White noise of density N and a bias that walks with K, sampled for `seconds`.
std::vector<double> Rate(double N, double K, double seconds, uint64_t seed) {
  CounterRng rng(seed, 3, 1);
  std::vector<double> out;
  double bias = 0.02;
  for (double t = 0; t < seconds; t += kDt) {
    bias += K * std::sqrt(kDt) * rng.Normal();
    out.push_back(bias + N / std::sqrt(kDt) * rng.Normal());
  }
  return out;
}

TEST(Allan, VarianceOfWhiteNoiseFallsWithTheAveragingTime) {
  const auto points = AllanVariance(Rate(2e-3, 0, 400, 1), kDt);
  ASSERT_GE(points.size(), 12u);
  EXPECT_DOUBLE_EQ(points[0].tau_s, kDt);
  EXPECT_DOUBLE_EQ(points[3].tau_s, 8 * kDt);
  for (const AllanPoint& point : points) {
    EXPECT_NEAR(point.variance * point.tau_s / 4e-6, 1, 4 * point.relative) << point.tau_s;
  }
}

TEST(Allan, ARampGivesItsSlope) {
  // Bias that grows by 1e-3 per second: the variance is (slope tau)^2 / 2 (IEEE 952, C.1.5).
  std::vector<double> ramp;
  ramp.reserve(2000);
  for (int i = 0; i < 2000; ++i) ramp.push_back(1e-3 * i * kDt);
  for (const AllanPoint& point : AllanVariance(ramp, kDt)) {
    EXPECT_NEAR(point.variance, 0.5 * std::pow(1e-3 * point.tau_s, 2),
                1e-9 * point.variance + 1e-18);
  }
}

TEST(Allan, DensityAndWalkAreFoundWithinTheirErrors) {
  int inside = 0;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const NoiseModel found = FitNoise(AllanVariance(Rate(2e-4, 4e-5, 1800, seed), kDt));
    EXPECT_NEAR(found.density.value, 2e-4, 4e-6) << seed;
    ASSERT_TRUE(found.walk.determined()) << seed;
    EXPECT_NEAR(found.walk.value, 4e-5, 4 * found.walk.sigma) << seed;
    EXPECT_LT(found.walk.sigma, 2e-5) << seed;
    inside += std::abs(found.walk.value - 4e-5) < 2 * found.walk.sigma ? 1 : 0;
  }
  EXPECT_GE(inside, 8) << "of 10 within two standard deviations";
}

TEST(Allan, AShortStandstillDoesNotTellTheWalk) {
  const NoiseModel found = FitNoise(AllanVariance(Rate(2e-4, 3e-6, 120, 5), kDt));
  EXPECT_NEAR(found.density.value, 2e-4, 1e-5);
  EXPECT_FALSE(found.walk.determined());
  EXPECT_GT(found.walk.value + 2 * found.walk.sigma, 3e-6) << "the bound holds";
}

TEST(Allan, CoarseStepsOfTheReadingAreNotTakenForWhiteNoise) {
  auto rate = Rate(2e-4, 0, 600, 7);
  double sum = 0, rounded_before = 0;
  // A counter of angle in steps of 2e-5 rad, differenced: quantisation noise.
  for (double& value : rate) {
    sum += value * kDt;
    const double rounded = std::round(sum / 2e-5) * 2e-5;
    value = (rounded - rounded_before) / kDt;
    rounded_before = rounded;
  }
  EXPECT_NEAR(FitNoise(AllanVariance(rate, kDt)).density.value, 2e-4, 3e-5);
}

}  // namespace
}  // namespace gw::calibrate

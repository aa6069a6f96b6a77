#include "frontend/core/motion/dr_trust.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

constexpr double kSigma = 0.01;  // m and rad, of both witnesses

// A window of honest noise, in which the robot moves by 0.4 m and DR says that it moved and turned
// so many times as much.
DrEvidence Window(CounterRng& rng, double claimed_sigma = kSigma, double way = 1) {
  Vector6d motion = Vector6d::Zero();
  motion[0] = 0.4;
  DrEvidence out;
  Vector6d noise_dr;
  Vector6d noise_vision;
  for (int i = 0; i < 6; ++i) {
    noise_dr[i] = kSigma * rng.Normal();
    noise_vision[i] = kSigma * rng.Normal();
  }
  out.T_vision = SE3::Exp(motion + noise_vision);
  motion[0] *= way;
  out.T_dr = SE3::Exp(motion + noise_dr);
  out.cov_dr = claimed_sigma * claimed_sigma * Matrix6d::Identity();
  out.cov_vision = kSigma * kSigma * Matrix6d::Identity();
  return out;
}

DrNoise Claimed() {
  DrNoise noise;
  noise.white = 1e-6 * Matrix6d::Identity();
  return noise;
}

TEST(DrTrust, HonestNoiseIsBelievedAsItIs) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    CounterRng rng(seed, 1, 0);
    DrTrust trust;
    for (int i = 0; i < 300; ++i) {
      trust.Judge(Window(rng));
      ASSERT_TRUE(trust.trusted()) << seed << " " << i;
    }
    const Vector6d shown = trust.Shown(Claimed()).Covariance().diagonal();
    EXPECT_LT(shown.maxCoeff(), 2.5e-6) << "the mean of 20 windows scatters";
  }
}

TEST(DrTrust, NoiseThatIsClaimedTooSmallIsScaledUp) {
  CounterRng rng(1, 2, 0);
  DrTrust trust;
  // Vision as sure as dead reckoning claims to be: all of the error is dead reckoning's.
  for (int i = 0; i < 200; ++i) {
    DrEvidence window = Window(rng, kSigma / 2);
    window.cov_vision *= 0.25;
    trust.Judge(window);
  }
  EXPECT_TRUE(trust.trusted());
  const Vector6d shown = trust.Shown(Claimed()).Covariance().diagonal();
  EXPECT_GT(shown.mean(), 2e-6);
  EXPECT_LT(shown.mean(), 8e-6);
}

TEST(DrTrust, ASingleWindowThatIsFarOffSaysLittleOfTheNoise) {
  CounterRng rng(5, 6, 0);
  DrTrust trust;
  for (int i = 0; i < 60; ++i) trust.Judge(Window(rng));
  trust.Judge(Window(rng, kSigma, 2));  // a slip of a second: 28 sigmas along the way
  EXPECT_TRUE(trust.trusted());
  EXPECT_LT(trust.Shown(Claimed()).Covariance().diagonal().maxCoeff(), 3e-6);
}

TEST(DrTrust, AContradictionThatLastsCostsTrustUntilItEnds) {
  CounterRng rng(2, 3, 0);
  DrTrust trust;
  for (int i = 0; i < 30; ++i) trust.Judge(Window(rng));
  for (int i = 0; i < 2; ++i) trust.Judge(Window(rng, kSigma, 2));
  EXPECT_TRUE(trust.trusted()) << "it may be a slip";
  trust.Judge(Window(rng, kSigma, 2));
  EXPECT_FALSE(trust.trusted());
  int windows = 0;
  while (!trust.trusted() && windows < 20) {
    trust.Judge(Window(rng));
    ++windows;
  }
  EXPECT_EQ(windows, 5);
}

TEST(DrTrust, StandingStillIsNoAgreement) {
  CounterRng rng(3, 4, 0);
  DrTrust trust;
  for (int i = 0; i < 5; ++i) trust.Judge(Window(rng, kSigma, 2));
  DrEvidence still;
  still.cov_dr = still.cov_vision = kSigma * kSigma * Matrix6d::Identity();
  for (int i = 0; i < 100; ++i) trust.Judge(still);
  EXPECT_FALSE(trust.trusted());
}

TEST(DrTrust, TheNominalNoiseFallsWithWhatWasShown) {
  CounterRng rng(4, 5, 0);
  DrTrust trust;
  const Matrix6d nominal = 1e-2 * Matrix6d::Identity();
  const Matrix6d shown = 1e-8 * Matrix6d::Identity();
  EXPECT_NEAR(trust.Weighted(nominal, shown)(0, 0), 1e-2, 1e-9);
  for (int i = 0; i < 45; ++i) trust.Judge(Window(rng));
  EXPECT_NEAR(trust.Weighted(nominal, shown)(0, 0), 1e-4, 1e-9) << "a tenth of the sigma";
  const Matrix6d large = Matrix6d::Identity();
  EXPECT_NEAR(trust.Weighted(nominal, large)(5, 5), 1, 1e-9);
}

}  // namespace
}  // namespace gw::frontend

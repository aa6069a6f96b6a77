#include "tools/data/import/synthetic_dr.h"

#include <gmock/gmock.h>

#include <cmath>

#include "common/good_weights/dr_history.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

using testing::HasSubstr;

// A body on a wavy path, sampled at 50 Hz.
std::vector<GroundTruth> WavyPath(double seconds) {
  std::vector<GroundTruth> truth;
  SE3 T_GB(ExpSO3({0.1, 0.2, 1.0}), {1, 2, 3});
  for (int i = 0; i <= static_cast<int>(seconds * 50); ++i) {
    GroundTruth sample;
    sample.utime = {1000000 + i * 20000};
    sample.T_GB = T_GB;
    truth.push_back(sample);
    Vector6d twist;
    twist << 0.5, 0.02 * std::sin(0.01 * i), 0, 0, 0.1 * std::cos(0.02 * i), 0.3;
    T_GB = T_GB * SE3::Exp(twist * 0.02);
  }
  return truth;
}

// Error of one increment as the consumer sees it, right perturbation.
Vector6d IncrementError(const std::vector<StampedPose>& truth, const DrIncrement& increment) {
  const SE3 T_BaBb =
      PoseAt(truth, increment.utime_begin).inverse() * PoseAt(truth, increment.utime_end);
  return (T_BaBb.inverse() * increment.T_BaBb).Log();
}

std::vector<StampedPose> Poses(const std::vector<GroundTruth>& truth) {
  std::vector<StampedPose> out;
  for (const GroundTruth& sample : truth) out.push_back({sample.utime, sample.T_GB});
  return out;
}

std::vector<DrState> Make(const std::vector<GroundTruth>& truth, const SyntheticDrOptions& o) {
  std::vector<std::string> warnings;
  auto states = MakeSyntheticDr(truth, o, warnings);
  EXPECT_TRUE(states);
  return *states;
}

TEST(SyntheticDr, WithoutNoiseIsTheTrueMotion) {
  const auto truth = WavyPath(5);
  SyntheticDrOptions o;
  o.sigma_t_m = o.sigma_r_rad = 0;
  const auto states = Make(truth, o);
  ASSERT_EQ(states.size(), 501u);
  const auto poses = Poses(truth);
  for (const DrState& s : states) {
    const SE3 error = s.T_OB.inverse() * poses.front().T.inverse() * PoseAt(poses, s.utime);
    ASSERT_LT(error.Log().norm(), 1e-9);
    ASSERT_TRUE(s.synthetic);
  }
  EXPECT_NEAR(states[100].v_OB_B.x(), 0.5, 1e-3);
  EXPECT_NEAR(states[100].w_OB_B.z(), 0.3, 1e-3);
}

// The claim of the option: per 1/30 s and axis, the stated sigma, whatever the DR rate.
TEST(SyntheticDr, IncrementNoiseMatchesTheStatedSigmaAtAnyRate) {
  const auto truth = WavyPath(200);
  const auto poses = Poses(truth);
  for (const double rate : {30.0, 60.0, 120.0}) {
    SyntheticDrOptions o;
    o.rate_hz = rate;
    o.seed = 7;
    const auto states = Make(truth, o);
    const auto step = static_cast<size_t>(rate / 30);
    Vector6d sum2 = Vector6d::Zero();
    int count = 0;
    for (size_t i = step; i < states.size(); i += step, ++count) {
      DrIncrement inc;
      inc.utime_begin = states[i - step].utime;
      inc.utime_end = states[i].utime;
      inc.T_BaBb = states[i - step].T_OB.inverse() * states[i].T_OB;
      sum2 += IncrementError(poses, inc).cwiseAbs2();
    }
    ASSERT_GT(count, 5900);
    const Vector6d sigma = (sum2 / count).cwiseSqrt();
    // Standard error of a sigma from 6000 samples is 0.9 %; five of them.
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(sigma[i] / 0.004, 1, 0.045) << rate << " " << i;
    for (int i = 3; i < 6; ++i) EXPECT_NEAR(sigma[i] / o.sigma_r_rad, 1, 0.045) << rate << " " << i;
  }
}

// NEES of increments over a second, with white and coherent parts: the covariance that the consumer
// composes from the states must describe the errors.
TEST(SyntheticDr, ReportedCovarianceIsHonest) {
  const auto truth = WavyPath(30);
  const auto poses = Poses(truth);
  double nees = 0;
  int count = 0;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    SyntheticDrOptions o;
    o.seed = seed;
    o.bias_t_m_s = 0.05;
    o.bias_r_rad_s = 0.02;
    o.walk_t_m_s_sqrt_s = 0.01;
    o.walk_r_rad_s_sqrt_s = 0.004;
    DrHistory history({60000000});
    for (const DrState& s : Make(truth, o)) ASSERT_TRUE(history.Push(s));
    for (const int64_t begin : {1500000, 15000000}) {
      const auto inc = history.Increment({begin}, {begin + 1000000});
      ASSERT_TRUE(inc);
      EXPECT_TRUE(inc->synthetic);
      const Vector6d e = IncrementError(poses, *inc);
      nees += e.dot(inc->cov.ldlt().solve(e));
      ++count;
    }
  }
  // Chi-square with 6 degrees of freedom: mean 6, standard deviation of the mean sqrt(12 / count).
  EXPECT_NEAR(nees / count, 6, 4 * std::sqrt(12.0 / count));
}

TEST(SyntheticDr, CovarianceOfThePoseIsHonest) {
  const auto truth = WavyPath(10);
  const auto poses = Poses(truth);
  double nees = 0;
  const int kRuns = 200;
  for (uint64_t seed = 1; seed <= kRuns; ++seed) {
    SyntheticDrOptions o;
    o.seed = seed;
    o.rate_hz = 50;
    o.bias_t_m_s = 0.02;
    o.bias_r_rad_s = 0.005;
    const DrState last = Make(truth, o).back();
    const Vector6d e =
        ((poses.front().T.inverse() * PoseAt(poses, last.utime)).inverse() * last.T_OB).Log();
    nees += e.dot(last.cov_T_OB.ldlt().solve(e));
  }
  EXPECT_NEAR(nees / kRuns, 6, 4 * std::sqrt(12.0 / kRuns));
}

TEST(SyntheticDr, SameSeedGivesTheSameBytesAnotherSeedNot) {
  const auto truth = WavyPath(2);
  SyntheticDrOptions o;
  o.bias_t_m_s = 0.1;
  const auto a = Make(truth, o);
  const auto b = Make(truth, o);
  o.seed = 2;
  const auto c = Make(truth, o);
  EXPECT_EQ(a.back().T_OB.translation(), b.back().T_OB.translation());
  EXPECT_NE(a.back().T_OB.translation(), c.back().T_OB.translation());
}

TEST(SyntheticDr, WarnsOfAGapInTheGroundTruth) {
  auto truth = WavyPath(3);
  truth.erase(truth.begin() + 20, truth.begin() + 60);
  std::vector<std::string> warnings;
  ASSERT_TRUE(MakeSyntheticDr(truth, {}, warnings));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("gap of 0.82 s"));
}

TEST(SyntheticDr, NeedsGroundTruth) {
  std::vector<std::string> warnings;
  EXPECT_FALSE(MakeSyntheticDr({}, {}, warnings));
}

TEST(SyntheticDr, OptionsAcceptDegreesAndRadiansAndSayWhatIsWrong) {
  const auto o = ParseSyntheticDr(
      "sigma_t=0.01,sigma_r=0.5deg,bias_t=0.1,bias_r=0.002rad,walk_t=0.3,walk_r=1deg,rate=50,"
      "seed=18446744073709551615");
  ASSERT_TRUE(o) << o.error().message;
  EXPECT_EQ(o->sigma_t_m, 0.01);
  EXPECT_NEAR(o->sigma_r_rad, 0.0087266, 1e-7);
  EXPECT_EQ(o->bias_r_rad_s, 0.002);
  EXPECT_EQ(o->rate_hz, 50);
  EXPECT_EQ(o->seed, UINT64_MAX);
  const auto again = ParseSyntheticDr(Describe(*o));
  ASSERT_TRUE(again);
  EXPECT_NEAR(again->sigma_r_rad, o->sigma_r_rad, 1e-10);
  for (const char* bad :
       {"sigma_r=0.1", "sigma_t=0.1deg", "sigma_t=-1", "sigma_t", "sigma_t=nan", "x=1", "rate=0",
        "rate=1e9", "seed=1.5", "sigma_t=1,sigma_t=2", "seed=-1", ","}) {
    const auto result = ParseSyntheticDr(bad);
    ASSERT_FALSE(result) << bad;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument) << bad;
  }
}

}  // namespace
}  // namespace gw::importer

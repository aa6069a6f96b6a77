#include "tools/lab/eval/smooth.h"

#include <gtest/gtest.h>

#include "tools/lab/eval/test_trajectories.h"

namespace gw::eval {
namespace {

// A robot with a trapezoid of speed and of turning: drives 1.5 m, turns by 90 deg where it stands,
// and so on.
SE3 Drive(double t) {
  constexpr double kLeg = 4.5, kCorner = 2.5, kQuarter = 1.5707963267948966;
  const auto ramp = [](double s) {  // from 0 to 1 over [0, 1], rate 0 at the ends
    s = std::clamp(s, 0.0, 1.0);
    if (s < 0.2) return s * s / 0.32;
    if (s > 0.8) return 1 - (1 - s) * (1 - s) / 0.32;
    return (s - 0.1) / 0.8;
  };
  SE3 T;
  for (; t > 0; t -= kLeg + kCorner) {
    const SE3 leg(Eigen::Quaterniond::Identity(), {1.5 * ramp(t / kLeg), 0, 0});
    const SE3 corner(ExpSO3({0, 0, kQuarter * ramp((t - kLeg) / kCorner)}), {0, 0, 0});
    T = T * leg * corner;
  }
  return T;
}

constexpr double kMetres = 0.02, kRadians = 0.01;

Trajectory NoisyDrive(double seconds, uint64_t seed) {
  Trajectory out;
  for (int i = 0; i < static_cast<int>(10 * seconds); ++i) {
    CounterRng rng(seed, 7, static_cast<uint64_t>(i));
    const SE3 T = Drive(0.1 * i);
    const Eigen::Vector3d dp(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Vector3d dr(rng.Normal(), rng.Normal(), rng.Normal());
    out.push_back({UtimeFromSeconds(0.1 * i),
                   SE3(T.rotation() * ExpSO3(kRadians * dr), T.translation() + kMetres * dp)});
  }
  return out;
}

struct Errors {
  double metres, radians;
};

template <typename Pose>
Errors RmsError(const Trajectory& times, const Pose& pose) {
  double m2 = 0, r2 = 0;
  for (const TimedPose& at : times) {
    const SE3 error = Drive(at.utime.seconds()).inverse() * pose(at);
    m2 += error.translation().squaredNorm();
    r2 += LogSO3(error.rotation()).squaredNorm();
  }
  const auto n = static_cast<double>(times.size());
  return {std::sqrt(m2 / n), std::sqrt(r2 / n)};
}

TEST(Smooth, HalvesTheNoiseOfADriveAndSaysHowWellSamplesAreForetold) {
  const Trajectory samples = NoisyDrive(35, 1);
  const auto smoothed = Smooth(samples, {});
  ASSERT_TRUE(smoothed.ok()) << smoothed.error().message;
  EXPECT_NEAR(smoothed->noise.position_m, kMetres, 0.2 * kMetres);
  EXPECT_NEAR(smoothed->noise.rotation_rad, kRadians, 0.2 * kRadians);
  const Errors raw = RmsError(samples, [](const TimedPose& s) { return s.T; });
  const Errors smooth =
      RmsError(samples, [&](const TimedPose& s) { return smoothed->spline.Pose(s.utime); });
  EXPECT_LE(smooth.metres, 0.5 * raw.metres);
  // One spacing for a way that is driven straight and turned sharply: rotation gains less.
  EXPECT_LE(smooth.radians, 0.6 * raw.radians);
  // A left out sample is off by its own noise and by the error of the spline.
  const SpacingFit& fit = smoothed->tried[smoothed->chosen];
  EXPECT_NEAR(fit.left_out_m.rmse, std::hypot(raw.metres, smooth.metres), 0.1 * raw.metres);
  for (const SpacingFit& other : smoothed->tried) EXPECT_GE(other.score, fit.score);
}

// The formula against what it stands for.
TEST(Smooth, LeftOutResidualsAreThoseOfFitsWithoutTheSample) {
  const Trajectory samples = NoisyDrive(6, 2);
  SmoothOptions options;
  options.spacing = Milliseconds(400);
  const auto all = Smooth(samples, options);
  ASSERT_TRUE(all.ok());
  std::vector<double> refitted;
  for (size_t i = 0; i < samples.size(); ++i) {
    Trajectory rest = samples;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    const auto fit = Smooth(rest, options);
    ASSERT_TRUE(fit.ok());
    refitted.push_back(
        (fit->spline.Pose(samples[i].utime).translation() - samples[i].T.translation()).norm());
  }
  // A refit measures the noise anew, and its spline ends where its samples end.
  const double median = Summarise(refitted).median;
  EXPECT_NEAR(all->tried[0].left_out_m.median, median, 0.05 * median);
}

TEST(Smooth, JumpsPullLittle) {
  Trajectory samples = NoisyDrive(35, 3);
  for (size_t i = 20; i < samples.size(); i += 50) {
    samples[i].T = samples[i].T * SE3(Eigen::Quaterniond::Identity(), {0.5, 0.5, 0});
  }
  const auto smoothed = Smooth(samples, {});
  ASSERT_TRUE(smoothed.ok());
  const Errors error =
      RmsError(samples, [&](const TimedPose& s) { return smoothed->spline.Pose(s.utime); });
  EXPECT_LE(error.metres, 0.5 * std::sqrt(3.0) * kMetres);
  EXPECT_GE(smoothed->tried[smoothed->chosen].outliers, 7);
}

TEST(Smooth, AGyroTellsRotationAndItsBiasIsFound) {
  const Trajectory samples = NoisyDrive(35, 4);
  const Eigen::Vector3d bias(0.01, -0.02, 0.005);
  SmoothOptions options;
  options.spacing = Milliseconds(400);
  const auto without = Smooth(samples, options);
  for (int i = 0; i < 3500; ++i) {
    CounterRng rng(1, 8, static_cast<uint64_t>(i));
    const double t = 0.01 * i;
    const Eigen::Vector3d rate =
        LogSO3(Drive(t - 5e-4).rotation().conjugate() * Drive(t + 5e-4).rotation()) / 1e-3;
    options.gyro.push_back(
        {UtimeFromSeconds(t),
         rate + bias + 0.01 * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal())});
  }
  const auto with = Smooth(samples, options);
  ASSERT_TRUE(without.ok() && with.ok());
  const auto radians = [&](const Smoothed& s) {
    return RmsError(samples, [&](const TimedPose& at) { return s.spline.Pose(at.utime); }).radians;
  };
  EXPECT_LT(radians(*with), 0.7 * radians(*without));
  ASSERT_TRUE(with->has_gyro);
  EXPECT_LT((with->gyro_bias - bias).norm(), 2e-3);
}

TEST(Smooth, PausesStayPauses) {
  Trajectory samples = NoisyDrive(20, 5);
  samples.erase(samples.begin() + 80, samples.begin() + 120);
  const auto smoothed = Smooth(samples, {});
  ASSERT_TRUE(smoothed.ok());
  for (const TimedPose& pose : Sample(*smoothed, samples, 50)) {
    ASSERT_TRUE(pose.T.IsFinite());
    EXPECT_TRUE(pose.utime.seconds() < 7.91 || pose.utime.seconds() > 11.99)
        << pose.utime.seconds();
    EXPECT_LT((Drive(pose.utime.seconds()).inverse() * pose.T).translation().norm(), 0.1);
  }
  samples.resize(7);
  EXPECT_FALSE(Smooth(samples, {}).ok());
}

}  // namespace
}  // namespace gw::eval

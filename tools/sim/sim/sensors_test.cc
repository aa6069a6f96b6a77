#include "tools/sim/sim/sensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tools/sim/sim/depth_sensor.h"
#include "tools/sim/sim/floor_profile.h"
#include "tools/sim/sim/mounting.h"
#include "tools/sim/sim/odometry_resampler.h"

namespace gw::sim {
namespace {

// Allan deviation of rate samples at averaging time m * dt, non-overlapping.
double AllanDeviation(const std::vector<double>& samples, size_t m) {
  double before = 0, sum = 0;
  size_t count = 0;
  for (size_t begin = 0; begin + m <= samples.size(); begin += m) {
    double mean = 0;
    for (size_t i = 0; i < m; ++i) mean += samples[begin + i];
    mean /= static_cast<double>(m);
    if (begin > 0) {
      sum += (mean - before) * (mean - before);
      ++count;
    }
    before = mean;
  }
  return std::sqrt(sum / (2 * static_cast<double>(count)));
}

std::vector<double> GyroAtRest(const ImuConfig& config, double seconds) {
  ImuSensor imu(config, SE3(), 7);
  std::vector<double> z;
  const double dt = 1 / config.rate_hz;
  for (int i = 1; i <= seconds * config.rate_hz; ++i) {
    const ImuSample s =
        imu.Measure(UtimeFromSeconds(i * dt), dt, SE3(), Eigen::Vector3d::Zero(), 0);
    z.push_back(s.w_I_rad_s.z());
  }
  return z;
}

TEST(ImuSensor, AllanDeviationOfTheGyroShowsItsNoiseDensity) {
  ImuConfig config;
  config.gyro_walk = 0;
  const auto z = GyroAtRest(config, 1000);
  for (const size_t m : {20, 100, 200}) {  // density / sqrt(tau)
    const double tau = static_cast<double>(m) / config.rate_hz;
    EXPECT_NEAR(AllanDeviation(z, m) / (config.gyro_noise / std::sqrt(tau)), 1, 0.1) << tau;
  }
}

TEST(ImuSensor, AllanDeviationOfTheGyroShowsItsBiasWalk) {
  ImuConfig config;
  config.gyro_noise = 1e-7;
  const auto z = GyroAtRest(config, 4000);
  for (const size_t m : {400, 2000, 4000}) {  // walk * sqrt(tau / 3)
    const double tau = static_cast<double>(m) / config.rate_hz;
    EXPECT_NEAR(AllanDeviation(z, m) / (config.gyro_walk * std::sqrt(tau / 3)), 1, 0.2) << tau;
  }
}

TEST(ImuSensor, MeasuresRotationAndGravityInItsOwnFrame) {
  ImuConfig quiet;
  quiet.gyro_bias = quiet.accel_bias = quiet.gyro_walk = quiet.accel_walk = 0;
  quiet.gyro_noise = quiet.accel_noise = 1e-9;
  quiet.gyro_scale_error = 0;
  // The IMU's y axis points down: gravity's reaction is along -y, a turn to the left along -y too.
  const SE3 T_BI(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.2});
  ImuSensor imu(quiet, T_BI, 1);
  ImuSample sample;
  for (int i = 0; i < 10; ++i) {
    sample = imu.Measure(Utime{5000 * (i + 1)}, 0.005, SE3(ExpSO3({0, 0, 0.005 * i}), {0, 0, 0}),
                         Eigen::Vector3d::Zero(), 0);
  }
  EXPECT_NEAR(sample.w_I_rad_s.y(), -1.0, 1e-6);
  EXPECT_NEAR(sample.a_I_m_s2.y(), -9.80665, 1e-6);
  EXPECT_EQ(sample.utime.us, 47500) << "the middle of the interval";
}

TEST(ImuSensor, EveryAxisOfTheGyroHasItsOwnScale) {
  ImuConfig quiet;
  quiet.gyro_bias = quiet.gyro_walk = 0;
  quiet.gyro_noise = 1e-9;
  quiet.gyro_scale_error = 0.01;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    ImuSensor imu(quiet, SE3(), seed);
    Eigen::Vector3d w;
    for (int i = 0; i < 3; ++i) {
      w = imu.Measure(Utime{5000 * (i + 1)}, 0.005, SE3(ExpSO3({0, 0, 0.005 * i}), {0, 0, 0}),
                      Eigen::Vector3d::Zero(), 0)
              .w_I_rad_s;
    }
    EXPECT_GE(std::abs(w.z() - 1), 0.006 - 1e-6) << seed;
    EXPECT_LE(std::abs(w.z() - 1), 0.014 + 1e-6) << seed;
  }
}

// Drives for `seconds`; error of the wheels' odometry over every 10 m, share of the way.
double MeanDrift(uint64_t seed) {
  floorplan::FloorMap hall;
  hall.width = hall.height = 1000;
  hall.resolution = 0.5;
  hall.origin = {-250, -250};
  hall.occupied.assign(1000 * 1000, 0);
  const std::vector<float> distance(hall.occupied.size(), 5.0f);
  Base base({}, hall, distance, seed);
  WheelSensor wheels(base.config().track_m, 11724.4, seed);
  base.Place({0, 0}, 0);
  SE3 odometry;
  std::vector<std::pair<SE3, SE3>> poses;  // truth, odometry
  double way = 0;
  for (int ms = 0; ms < 200'000; ++ms) {
    const double t = ms * 1e-3;
    if (ms % 50 == 0) base.Command(t, 0.5, 0.5 * std::sin(t / 4));
    const Eigen::Vector2d before = base.position();
    base.Step(t, 1e-3, {});
    way += (base.position() - before).norm();
    if (ms % 20 != 19) continue;
    const WheelSample s = wheels.Measure(Utime{(ms + 1) * 1000}, base.left_way(), base.right_way(),
                                         base.yaw(), false);
    odometry = odometry * SE3(ExpSO3({0, 0, s.dyaw_rad}), {s.dx_m, s.dy_m, 0});
    if (way >= 10.0 * static_cast<double>(poses.size())) {
      poses.emplace_back(
          SE3(ExpSO3({0, 0, base.yaw()}), {base.position().x(), base.position().y(), 0}), odometry);
    }
  }
  double sum = 0;
  for (size_t i = 1; i < poses.size(); ++i) {
    const SE3 truth = poses[i - 1].first.inverse() * poses[i].first;
    const SE3 measured = poses[i - 1].second.inverse() * poses[i].second;
    sum += (truth.translation() - measured.translation()).norm() / 10;
  }
  return sum / static_cast<double>(poses.size() - 1);
}

TEST(WheelSensor, OdometryDriftsOneToThreePercentOfTheWay) {
  double sum = 0;
  constexpr int kRobots = 12;
  for (uint64_t seed = 1; seed <= kRobots; ++seed) {
    const double drift = MeanDrift(seed);
    EXPECT_GT(drift, 0.004) << seed;
    EXPECT_LT(drift, 0.035) << seed;
    sum += drift;
  }
  std::printf("wheel drift over 10 m: mean %.2f %%\n", 100 * sum / kRobots);
  EXPECT_GT(sum / kRobots, 0.01);
  EXPECT_LT(sum / kRobots, 0.03);
}

TEST(WheelSensor, TicksWrapAndMeanTheSameAsTheMotion) {
  WheelSensor wheels(0.23, 11724.4, 1);
  double sum = 0;
  uint16_t before = 0;
  int64_t ticks = 0;
  for (int i = 0; i < 1000; ++i) {
    const WheelSample s = wheels.Measure(Utime{20'000 * (i + 1)}, 0.013 * i, 0.013 * i, 0, false);
    if (i > 0) ticks += static_cast<int16_t>(static_cast<uint16_t>(s.left_ticks - before));
    before = s.left_ticks;
    sum += s.dx_m;
    EXPECT_EQ((s.utime - s.utime_begin).us, 20'000);
    EXPECT_EQ(s.utime.us, 20'000 * (i + 1));
  }
  EXPECT_NEAR(sum, 0.013 * 999, 1e-4);
  EXPECT_NEAR(static_cast<double>(ticks) / 11724.4, sum, 1e-9);
}

TEST(ImuSensor, ShakesWithTheSpeedAndComesBack) {
  ImuConfig config;
  config.shake_rad_s = 0.008;
  config.shake_m_s2 = 0.1;
  config.gyro_bias = config.gyro_walk = config.gyro_scale_error = 0;
  config.gyro_noise = 1e-9;
  config.accel_bias = config.accel_walk = 0;
  config.accel_noise = 1e-9;
  const double dt = 1 / config.rate_hz;
  for (const double speed : {0.0, 0.25, 0.5}) {
    ImuSensor imu(config, SE3(), 5);
    double turn = 0, squares = 0, accel_squares = 0;
    constexpr int kSamples = 20'000;
    for (int i = 1; i <= kSamples; ++i) {
      const ImuSample s =
          imu.Measure(UtimeFromSeconds(i * dt), dt, SE3(), Eigen::Vector3d::Zero(), speed);
      turn += s.w_I_rad_s.z() * dt;
      squares += s.w_I_rad_s.z() * s.w_I_rad_s.z() / kSamples;
      accel_squares += s.a_I_m_s2.x() * s.a_I_m_s2.x() / kSamples;
      ASSERT_LT(std::abs(turn), 1e-3) << "shaking is no turn";
    }
    EXPECT_NEAR(std::sqrt(squares), config.shake_rad_s * speed / 0.5, 1e-3) << speed;
    EXPECT_NEAR(std::sqrt(accel_squares), config.shake_m_s2 * speed / 0.5, 1e-2) << speed;
  }
}

// Drives a curve to the left for ten seconds; sideways way of the body in its own frame.
double SidewaysWay(const BaseConfig& config) {
  floorplan::FloorMap hall;
  hall.width = hall.height = 400;
  hall.resolution = 0.5;
  hall.origin = {-100, -100};
  hall.occupied.assign(400 * 400, 0);
  const std::vector<float> distance(hall.occupied.size(), 5.0f);
  Base base(config, hall, distance, 1);
  base.Place({0, 0}, 0);
  double sideways = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    const double t = ms * 1e-3;
    if (ms % 50 == 0) base.Command(t, 0.5, 0.5);
    const Eigen::Vector2d before = base.position();
    const double yaw = base.yaw();
    base.Step(t, 1e-3, {});
    const Eigen::Vector2d step = base.position() - before;
    const double middle = yaw + 0.5 * std::remainder(base.yaw() - yaw, 2 * std::numbers::pi);
    sideways += -std::sin(middle) * step.x() + std::cos(middle) * step.y();
  }
  return sideways;
}

TEST(Base, TyresSlideToTheOutsideOfACurve) {
  BaseConfig config;
  config.sideways_per_sqrt_m = 0;
  config.side_slip = 0;
  EXPECT_NEAR(SidewaysWay(config), 0, 1e-3);
  config.side_slip = 0.02;
  // Slip angle 0.02 * 0.25 m/s^2 over 5 m; the base needs half a second to get going.
  EXPECT_NEAR(SidewaysWay(config), -0.02 * 0.25 * 5, 0.004);
}

TEST(Base, ASkidSteerBaseTurnsLessThanItsGeometricTrackSays) {
  floorplan::FloorMap hall;
  hall.width = hall.height = 100;
  hall.resolution = 0.5;
  hall.origin = {-25, -25};
  hall.occupied.assign(100 * 100, 0);
  const std::vector<float> distance(hall.occupied.size(), 5.0f);
  BaseConfig config;
  config.track_factor = 1.9;
  config.turn_deg_per_sqrt_rad = 4;
  Base base(config, hall, distance, 3);
  base.Place({0, 0}, 0);
  double turn = 0, yaw = 0;
  for (int ms = 0; ms < 20'000; ++ms) {
    if (ms % 50 == 0) base.Command(ms * 1e-3, 0, 0.8);
    base.Step(ms * 1e-3, 1e-3, {});
    turn += std::remainder(base.yaw() - yaw, 2 * std::numbers::pi);
    yaw = base.yaw();
  }
  // It does what it is told, but for dead time (0.3 s) and its random turns (0.28 rad over 16 rad).
  EXPECT_NEAR(turn, 0.8 * 19.7, 3 * 0.28);
  const double by_odometry = (base.right_way() - base.left_way()) / config.track_m;
  EXPECT_NEAR(by_odometry / turn, 1.9, 0.1);
}

TEST(OdometryResampler, IncrementsCoverFortyAndSixtyMillisecondsAndNoWayIsLost) {
  OdometryConfig config;
  config.rate_hz = 20;
  config.stamp_jitter_ms = 0;
  const Utime start{1'000'000};
  OdometryResampler resampler(config, start, 1);
  std::vector<double> ways;
  double sum = 0;
  Utime before = start + DurationFromSeconds(config.delay_s);
  for (int ms = 1; ms <= 10'000; ++ms) {
    const Utime now = start + Milliseconds(ms);
    if (ms % 20 == 0) {
      WheelSample packet;
      packet.dx_m = 0.02;  // 1 m/s
      resampler.Push(packet);
    }
    const auto sample = resampler.Take(now);
    if (!sample) continue;
    EXPECT_EQ(sample->utime_begin, before);
    EXPECT_EQ((sample->utime - sample->utime_begin).us, 50'000);
    before = sample->utime;
    ways.push_back(sample->dx_m);
    sum += sample->dx_m;
  }
  ASSERT_EQ(ways.size(), 200u);
  EXPECT_NEAR(sum, 10, 1e-9);
  EXPECT_NEAR(ways[100], 0.04, 1e-9);
  EXPECT_NEAR(ways[101], 0.06, 1e-9);
}

TEST(OdometryResampler, StampsAreLateInOrderAndByTheSizeOfTheJitter) {
  OdometryConfig config;
  config.rate_hz = 20;
  config.stamp_jitter_ms = 5;
  OdometryResampler resampler(config, Utime{0}, 1);
  std::vector<double> late_ms;
  Utime before{-1};
  for (int ms = 1; ms <= 100'000; ++ms) {
    const auto sample = resampler.Take(Utime{ms * 1000});
    if (!sample) continue;
    EXPECT_GT(sample->utime, before);
    before = sample->utime;
    const double due = config.delay_s + (static_cast<double>(sample->seq) + 1) / config.rate_hz;
    late_ms.push_back(1e3 * (sample->utime.seconds() - due));
    EXPECT_GE(late_ms.back(), -1e-3);
  }
  double squares = 0;
  for (const double late : late_ms) squares += late * late / static_cast<double>(late_ms.size());
  EXPECT_NEAR(std::sqrt(squares), 5, 0.4);
}

TEST(Mounting, IsOffByHalfADegreeToADegreeAndACentimetreWithEverySeed) {
  const SE3 nominal(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0.0175, 0.25});
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const SE3 mounted = MountedAt(nominal, {0.75, 0.01}, seed);
    const double turn = LogSO3(nominal.rotation().conjugate() * mounted.rotation()).norm();
    EXPECT_GE(turn * 180 / std::numbers::pi, 0.6 * 0.75 - 1e-6) << seed;
    EXPECT_LE(turn * 180 / std::numbers::pi, 1.4 * 0.75 + 1e-6) << seed;
    const double shift = (mounted.translation() - nominal.translation()).norm();
    EXPECT_GE(shift, 0.006 - 1e-9) << seed;
    EXPECT_LE(shift, 0.014 + 1e-9) << seed;
  }
  EXPECT_TRUE(MountedAt(nominal, {0, 0}, 1).translation().isApprox(nominal.translation()));
}

TEST(DepthSensor, NoiseGrowsWithTheSquareOfTheDistance) {
  WorkerPool pool(1);
  const Pinhole camera;
  const DepthConfig config;
  RenderedImage scene;
  scene.width = 640;
  scene.height = 480;
  std::vector<float> signal(640 * 480);
  for (size_t i = 0; i < signal.size(); ++i) signal[i] = static_cast<float>(i % 2 * 40 + i / 3 % 7);
  std::vector<uint16_t> depth;
  for (const double z : {0.63, 1.03, 1.57, 2.9, 4.1}) {
    scene.inverse_depth.assign(signal.size(), static_cast<float>(1 / z));
    MeasureDepth(scene, signal, camera, config, 11, &pool, &depth);
    double sum = 0, sum2 = 0;
    int count = 0;
    for (const uint16_t d : depth) {
      if (d == 0) continue;
      const double error = d * config.unit_m - z;
      sum += error;
      sum2 += error * error;
      ++count;
    }
    ASSERT_GT(count, 200'000) << z;
    const double rms = std::sqrt(sum2 / count);
    // Rounding to whole units adds unit^2 / 12, and one distance sees one phase of the steps.
    EXPECT_NEAR(rms / DepthSigma(config, camera.fx, z), 1, 0.25) << z;
    EXPECT_LT(std::abs(sum / count), rms) << z;
  }
}

TEST(DepthSensor, ABlankWallAndAnOccludedStripHaveNoDepth) {
  WorkerPool pool(1);
  const Pinhole camera;
  RenderedImage scene;
  scene.width = 640;
  scene.height = 480;
  scene.inverse_depth.assign(640 * 480, 0.5f);
  std::vector<uint16_t> depth;
  MeasureDepth(scene, std::vector<float>(640 * 480, 100.0f), camera, {}, 1, &pool, &depth);
  for (const uint16_t d : depth) ASSERT_EQ(d, 0);
  MeasureDepth(scene, std::vector<float>(640 * 480, 100.0f), camera, {.min_contrast_grey = 0}, 1,
               &pool, &depth);
  EXPECT_NEAR(depth[240 * 640 + 320], 2000, 300);
  // A post at 0.5 m before a wall at 2 m hides fx b (1/0.5 - 1/2) = 29 px of the wall, left of it.
  std::vector<float> signal(640 * 480);
  for (int i = 0; i < 640 * 480; ++i) {
    signal[i] = static_cast<float>(i % 2 * 60);
    if (i % 640 >= 300 && i % 640 < 340) scene.inverse_depth[i] = 2.0f;
  }
  for (size_t i = 0; i < signal.size(); ++i) signal[i] += static_cast<float>(i / 5 % 3 * 20);
  MeasureDepth(scene, signal, camera, {}, 1, &pool, &depth);
  const size_t row = 240 * 640;
  for (int x = 275; x < 298; ++x) EXPECT_EQ(depth[row + x], 0) << x;
  EXPECT_NEAR(depth[row + 260], 2000, 300);
  EXPECT_NEAR(depth[row + 320], 500, 30);
  EXPECT_NEAR(depth[row + 360], 2000, 300);
}

TEST(FloorProfile, TiltsTheBodyALittle) {
  const FloorProfile floor(3, 1);
  double worst = 0, sum = 0;
  for (int i = 0; i < 4000; ++i) {
    const SE3 T = floor.BodyPose({0.005 * i, 1.3}, 0.2);
    const Eigen::Vector3d up = T.rotation() * Eigen::Vector3d::UnitZ();
    const double tilt = std::acos(std::min(1.0, up.z())) * 180 / std::numbers::pi;
    worst = std::max(worst, tilt);
    sum += tilt;
  }
  EXPECT_GT(worst, 0.3);
  EXPECT_LT(worst, 3.0);
  EXPECT_LT(sum / 4000, 0.8);
}

}  // namespace
}  // namespace gw::sim

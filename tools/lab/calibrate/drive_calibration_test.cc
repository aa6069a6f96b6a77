// Drives made from a formula, with errors of calibration that are known.
#include "tools/lab/calibrate/drive_calibration.h"

#include <gmock/gmock.h>

#include <cmath>

#include "common/core/random.h"

namespace gw::calibrate {
namespace {

constexpr double kDegrees = 180 / M_PI;

// True values of one drive, and the noise that its sensors have.
struct Truth {
  SE3 T_BC = SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0.02, 0.3});
  double wheel_way = 1, wheel_turn = 1, gyro_turn = 1;  // true over measured
  double wheel_delay_s = 0, gyro_delay_s = 0, gyro_bias = 0.004;
};

double Gauss(CounterRng& rng) {
  double sum = 0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(rng.Below(1'000'000)) * 1e-6;
  return sum - 6;
}

struct Speed {
  double v = 0, w = 0;
};

// Figures of eight at changing speed.
Speed FigureOfEight(double t) {
  return {0.4 + 0.2 * std::sin(0.9 * t), 0.8 * std::sin(0.35 * t) + 0.2 * std::sin(1.7 * t)};
}
Speed StraightOn(double) {
  return {0.5, 0};
}
Speed OnTheSpot(double t) {
  return {0, 0.8 * std::sin(0.35 * t)};
}
Speed Standing(double) {
  return {};
}

struct Drive {
  std::vector<CameraPose> vision;
  std::vector<WheelSample> wheels;
  std::vector<ImuSample> imu;
};

// 60 s; the floor is flat but for tenths of degrees.
template <typename Path>
Drive MakeDrive(const Truth& truth, Path path, uint64_t seed) {
  Drive drive;
  CounterRng rng(seed, 1, 2);
  const double dt = 0.001;
  const auto at = [](double t) { return Utime{1'000'000'000 + std::llround(t * 1e6)}; };
  SE3 T_WB;
  SE3 drift;
  double way = 0, turn = 0;
  for (int i = 0; i <= 60'000; ++i) {
    const double t = i * dt;
    const Speed speed = path(t);
    if (i % 100 == 0) {
      Vector6d noise;
      for (int k = 0; k < 6; ++k) noise[k] = Gauss(rng) * (k < 3 ? 0.001 : 0.0004);
      Vector6d step = Vector6d::Zero();
      for (int k = 0; k < 6; ++k) step[k] = Gauss(rng) * (k < 3 ? 2e-4 : 1e-4);
      drift = drift * SE3::Exp(step);
      drive.vision.push_back({at(t), drift * T_WB * truth.T_BC * SE3::Exp(noise), true});
    }
    if (i % 20 == 0 && i > 0) {
      WheelSample sample;
      sample.utime = at(t + truth.wheel_delay_s);
      sample.utime_begin = at(t - 0.02 + truth.wheel_delay_s);
      sample.dyaw_rad = turn / truth.wheel_turn + 1e-4 * Gauss(rng);
      sample.dx_m = way / truth.wheel_way + 1e-4 * Gauss(rng);
      drive.wheels.push_back(sample);
      way = turn = 0;
    }
    if (i % 5 == 0) {
      ImuSample sample;
      sample.utime = at(t + truth.gyro_delay_s);
      sample.w_I_rad_s = {0.002 * Gauss(rng), 0.002 * Gauss(rng),
                          (speed.w + truth.gyro_bias) / truth.gyro_turn + 0.002 * Gauss(rng)};
      drive.imu.push_back(sample);
    }
    T_WB = T_WB * SE3(ExpSO3({0, 0, speed.w * dt}), {speed.v * dt, 0, 0});
    way += speed.v * dt;
    turn += speed.w * dt;
  }
  return drive;
}

// Up to 3 deg, 5 cm, 50 ms, 3 %, and a track of any size.
Truth RandomTruth(uint64_t seed) {
  CounterRng rng(seed, 7, 7);
  const auto within = [&](double size) {
    return size * (static_cast<double>(rng.Below(2'000'001)) * 1e-6 - 1);
  };
  Truth truth;
  const SE3 nominal = truth.T_BC;
  truth.T_BC = SE3(ExpSO3({within(3 / kDegrees), within(3 / kDegrees), within(3 / kDegrees)}) *
                       nominal.rotation(),
                   nominal.translation() + Eigen::Vector3d(within(0.05), within(0.05), 0));
  truth.wheel_way = 1 + within(0.03);
  truth.gyro_turn = 1 + within(0.03);
  truth.wheel_turn = std::exp(within(0.9));
  truth.wheel_delay_s = within(0.05);
  truth.gyro_delay_s = within(0.05);
  return truth;
}

std::array<double, kNumQuantities> Values(const Truth& truth) {
  const Eigen::Vector3d turn =
      LogSO3(truth.T_BC.rotation() * Truth().T_BC.rotation().conjugate()) * kDegrees;
  const Eigen::Vector3d place = truth.T_BC.translation() - Truth().T_BC.translation();
  return {
      turn.x(),        turn.y(),         turn.z(),        place.x(),           place.y(),
      truth.wheel_way, truth.wheel_turn, truth.gyro_turn, truth.wheel_delay_s, truth.gyro_delay_s};
}

Calibration Given() {
  Calibration given;
  given.camera.T_BC = Truth().T_BC;
  given.imu.present = given.wheel.present = true;
  return given;
}

TEST(DriveCalibration, FindsTwentyRandomErrorsWithinItsCovariance) {
  constexpr double kBars[kNumQuantities] = {0.1,   0.1,   0.1,   0.005, 0.005,
                                            0.002, 0.002, 0.002, 0.003, 0.003};
  int inside = 0, total = 0, exact = 0, beyond_bar = 0;
  double gyro_error = 0;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Truth truth = RandomTruth(seed);
    const Drive drive = MakeDrive(truth, FigureOfEight, seed);
    const auto found = CalibrateDrive(drive.vision, drive.wheels, drive.imu, Given());
    ASSERT_TRUE(found) << found.error().message;
    const auto expected = Values(truth);
    gyro_error += found->quantities[kGyroTurn].value / truth.gyro_turn - 1;
    for (size_t i = 0; i < kNumQuantities; ++i) {
      const Quantity& q = found->quantities[i];
      if (!q.determined()) continue;
      const double scale = i == kWheelTurn ? truth.wheel_turn : 1;
      const double error = std::abs(q.value - expected[i]);
      ++total;
      inside += error < 1.645 * q.sigma;
      exact += q.exact();
      beyond_bar += q.exact() && error > kBars[i] * scale;
      EXPECT_LT(error, 4 * q.sigma + 0.2 * kBars[i] * scale)
          << "seed " << seed << " " << q.name << " " << q.value << " +- " << q.sigma << ", truth "
          << expected[i];
    }
  }
  EXPECT_GT(total, 190);  // this drive determines all of them, most as well as is wanted
  EXPECT_GT(exact, 150);
  EXPECT_LE(beyond_bar, 6) << "of " << exact;
  // 90 % are expected inside of 1.645 standard deviations.
  RecordProperty("inside", inside);
  std::printf("inside 1.645 sigma: %d of %d; beyond the bar: %d\n", inside, total, beyond_bar);
  EXPECT_GT(inside, 0.8 * total);
  // What vision may tell wrong must not be drawn to where the residuals are small, which is what a
  // factor of 5e-4 on vision's turns would do; the mean of twenty gyros is known to 5e-5.
  EXPECT_NEAR(gyro_error / 20, 0, 2e-4);
}

TEST(DriveCalibration, AStraightDriveTellsNeitherPlaceNorTurns) {
  const Drive drive = MakeDrive(Truth(), StraightOn, 5);
  const auto found = CalibrateDrive(drive.vision, drive.wheels, drive.imu, Given());
  ASSERT_TRUE(found) << found.error().message;
  const auto& q = found->quantities;
  for (const int i : {kX, kY, kWheelTurn, kGyroTurn, kGyroDelay}) {
    EXPECT_FALSE(q[static_cast<size_t>(i)].determined()) << q[static_cast<size_t>(i)].name;
    EXPECT_FALSE(q[static_cast<size_t>(i)].remedy.empty());
  }
  EXPECT_TRUE(q[kYaw].determined());
  EXPECT_TRUE(q[kWheelWay].determined());
  EXPECT_THAT(MissingMotion(*found), testing::HasSubstr("without turning"));
  const Calibration corrected = Corrected(Given(), *found);
  EXPECT_EQ(corrected.camera.T_BC.translation(), Given().camera.T_BC.translation());
  EXPECT_EQ(corrected.wheel.track_width_m, Given().wheel.track_width_m);
}

std::vector<std::string> Undetermined(const DriveCalibration& found) {
  std::vector<std::string> names;
  for (const Quantity& q : found.quantities) {
    if (!q.determined()) names.push_back(q.name);
  }
  return names;
}

TEST(DriveCalibration, TurningOnTheSpotTellsNoWay) {
  const Drive drive = MakeDrive(Truth(), OnTheSpot, 5);
  const auto found = CalibrateDrive(drive.vision, drive.wheels, drive.imu, Given());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(Undetermined(*found), testing::ElementsAre("camera yaw", "wheel way scale"));
  EXPECT_THAT(MissingMotion(*found), testing::HasSubstr("drive straight"));
}

TEST(DriveCalibration, StandingTellsNothing) {
  const Drive drive = MakeDrive(Truth(), Standing, 5);
  const auto found = CalibrateDrive(drive.vision, drive.wheels, drive.imu, Given());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(Undetermined(*found).size(), size_t{kNumQuantities});
  EXPECT_THAT(MissingMotion(*found), testing::HasSubstr("the robot stood"));
  EXPECT_EQ(Corrected(Given(), *found).camera.T_BC.translation(),
            Given().camera.T_BC.translation());
}

TEST(DriveCalibration, WhatIsMissingIsNamed) {
  const Drive good = MakeDrive(Truth(), FigureOfEight, 1);
  const auto message = [](const Drive& drive) {
    const auto found = CalibrateDrive(drive.vision, drive.wheels, drive.imu, Given());
    return found ? "" : found.error().message;
  };
  EXPECT_EQ(message(good), "");
  Drive drive = good;
  drive.wheels.clear();
  EXPECT_THAT(message(drive), testing::HasSubstr("no wheel samples"));
  drive = good;
  for (WheelSample& sample : drive.wheels) {
    sample.utime_begin = sample.utime_begin + Milliseconds(3'600'000);
    sample.utime = sample.utime + Milliseconds(3'600'000);
  }
  EXPECT_THAT(message(drive), testing::HasSubstr("the wheels' clock"));
  drive = good;
  for (ImuSample& sample : drive.imu) sample.utime = sample.utime + Milliseconds(3'600'000);
  EXPECT_THAT(message(drive), testing::HasSubstr("the IMU's clock"));
  drive = good;
  for (size_t i = 60; i < drive.vision.size(); ++i) drive.vision[i].seen = false;
  EXPECT_THAT(message(drive), testing::HasSubstr("it placed 60 of 601 images"));
}

}  // namespace
}  // namespace gw::calibrate

#include "tools/lab/calibrate/imu_noise.h"

#include <gmock/gmock.h>

#include <cmath>

#include "common/core/random.h"

namespace gw::calibrate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kRate = 100;  // Hz

// A robot that stands: 1 degree of slope, small biases.
std::vector<ImuSample> Parked(double seconds, uint64_t seed = 1) {
  CounterRng rng(seed, 5, 1);
  std::vector<ImuSample> imu;
  for (int i = 0; i < seconds * kRate; ++i) {
    ImuSample sample;
    sample.utime = Utime{1'000'000'000 + static_cast<int64_t>(i * 1e6 / kRate)};
    sample.has_accel = true;
    for (int axis = 0; axis < 3; ++axis) {
      sample.w_I_rad_s[axis] = 0.004 + 3e-4 * (axis + 1) * std::sqrt(kRate) * rng.Normal();
      sample.a_I_m_s2[axis] = 2e-3 * std::sqrt(kRate) * rng.Normal();
    }
    sample.a_I_m_s2 += Eigen::Vector3d(0.17, 0, 9.8);
    imu.push_back(sample);
  }
  return imu;
}

Calibration Given() {
  Calibration given;
  given.imu.present = true;
  given.imu.rate_hz = kRate;
  return given;
}

TEST(ImuNoise, AParkedRobotTellsTheNoiseOfEachAxis) {
  const auto imu = Parked(600);
  const auto found = MeasureImuNoise(imu, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found->parked_s, 600, 2);
  EXPECT_NEAR(found->rate_hz, kRate, 1e-6);
  for (size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(found->gyro.axes[axis].density.value, 3e-4 * (static_cast<double>(axis) + 1), 2e-5);
    EXPECT_NEAR(found->accel.axes[axis].density.value, 2e-3, 1e-4);
  }
  EXPECT_THAT(JudgeStandstill(*found, Given()), IsEmpty());
  const ImuCalibration out = WithNoise(Given().imu, *found);
  EXPECT_NEAR(out.gyro_noise, 9e-4, 4e-5) << "the largest axis";
  EXPECT_EQ(out.gyro_walk, Given().imu.gyro_walk) << "white noise alone tells no walk";
}

TEST(ImuNoise, WhatMovesIsNoStandstill) {
  auto imu = Parked(400);
  for (size_t i = 0; i < imu.size(); ++i) {
    // Someone walks off with it for ten seconds, after two minutes.
    if (i > 120 * kRate && i < 130 * kRate) imu[i].w_I_rad_s.z() += 0.3;
  }
  const auto found = MeasureImuNoise(imu, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found->parked_s, 270, 3);
  EXPECT_NEAR(found->gyro.axes[2].density.value, 9e-4, 6e-5);
  WheelSample rolls;
  rolls.utime_begin = Utime{imu[30000].utime.us - 20'000};
  rolls.utime = imu[30000].utime;
  rolls.dx_m = 0.01;
  const auto rolled = MeasureImuNoise(imu, {rolls});
  ASSERT_TRUE(rolled);
  EXPECT_NEAR(rolled->parked_s, 170, 3);
}

TEST(ImuNoise, TooShortAStandstillAndADeadGyroAreErrors) {
  const auto shortly = MeasureImuNoise(Parked(50), {});
  ASSERT_FALSE(shortly);
  EXPECT_THAT(shortly.error().message, HasSubstr("the longest standstill lasts 4"));
  EXPECT_FALSE(MeasureImuNoise({}, {}));
  auto dead = Parked(100);
  for (ImuSample& sample : dead) sample.w_I_rad_s = {0.001, 0, 0};
  EXPECT_THAT(MeasureImuNoise(dead, {}).error().message, HasSubstr("dead"));
}

TEST(ImuNoise, LostSamplesAreFilledAndCounted) {
  auto imu = Parked(200);
  for (size_t i = 5000; i > 100; i -= 100) imu.erase(imu.begin() + static_cast<std::ptrdiff_t>(i));
  const auto found = MeasureImuNoise(imu, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->filled, 49);
  EXPECT_NEAR(found->parked_s, 200, 2);
  EXPECT_NEAR(found->gyro.axes[0].density.value, 3e-4, 2e-5);
}

// Units and axes that a robot at rest shows.
TEST(ImuNoise, UnitsAndAxesAreJudged) {
  const auto judge = [](const std::function<void(ImuSample&)>& spoil, const Calibration& given) {
    auto imu = Parked(100);
    for (ImuSample& sample : imu) spoil(sample);
    const auto found = MeasureImuNoise(imu, {});
    EXPECT_TRUE(found) << found.error().message;
    return JudgeStandstill(*found, given);
  };
  EXPECT_THAT(judge([](ImuSample& s) { s.a_I_m_s2 /= 9.80665; }, Given()),
              ElementsAre(HasSubstr("counts in g")));
  EXPECT_THAT(judge([](ImuSample& s) { s.a_I_m_s2.z() -= 9.8; }, Given()),
              ElementsAre(HasSubstr("gravity was taken off")));
  EXPECT_THAT(judge([](ImuSample& s) { s.w_I_rad_s.x() += 0.4; }, Given()),
              ElementsAre(HasSubstr("Degrees?")));
  // An optical frame (z forward, y down) that is stated as the body's.
  const Eigen::Quaterniond optical(0.5, -0.5, 0.5, -0.5);
  const auto turn = [&](ImuSample& s) { s.a_I_m_s2 = optical.conjugate() * s.a_I_m_s2; };
  EXPECT_THAT(judge(turn, Given()), ElementsAre(HasSubstr("gravity is 89")));
  Calibration stated = Given();
  stated.imu.T_BI = SE3(optical, {0, 0, 0});
  EXPECT_THAT(judge(turn, stated), IsEmpty());
  Calibration rate = Given();
  rate.imu.rate_hz = 200;
  EXPECT_THAT(judge([](ImuSample&) {}, rate), ElementsAre(HasSubstr("comes at 100.0 Hz")));
}

}  // namespace
}  // namespace gw::calibrate

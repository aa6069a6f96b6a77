// Units, axes and clock of an IMU, each wrong in turn, on a drive made here.
#include "tools/data/import/imu_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"
#include "tools/data/import/test_folder.h"

namespace gw::importer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kGravity = 9.81;  // m/s^2
constexpr Utime kBegin = {1600000000000000};

// Turn rate at t: stands for 2 s, then swings with a rhythm that does not repeat.
double TurnRate(double t) {
  return t < 2 ? 0 : 0.6 * std::sin(0.7 * t) * std::cos(0.23 * t + 0.1 * t * t / 40);
}

// A drive of 60 s: wheels at 20 Hz, IMU at 100 Hz with the axes of the body, bias and noise.
Recording Drive() {
  Recording recording;
  for (int i = 0; i < 1200; ++i) {
    WheelSample sample;
    sample.utime_begin = kBegin + Milliseconds(50 * i);
    sample.utime = kBegin + Milliseconds(50 * (i + 1));
    sample.dx_m = i < 40 ? 0 : 0.02;
    sample.dyaw_rad = 0.05 * TurnRate(0.05 * i + 0.025);
    recording.wheel.push_back(sample);
  }
  CounterRng rng(5, 1, 2);
  for (int i = 0; i < 6000; ++i) {
    ImuSample sample;
    sample.utime = kBegin + Milliseconds(10 * i);
    const auto noise = [&] { return 2 * rng.Uniform() - 1; };
    const bool moves = i > 200;
    sample.w_I_rad_s = {0.02 * noise(), 0.02 * noise(), TurnRate(0.01 * i) + 0.01 + 0.02 * noise()};
    sample.a_I_m_s2 = {(moves ? 0.8 : 0.05) * noise(), (moves ? 0.8 : 0.05) * noise(),
                       kGravity + (moves ? 0.8 : 0.05) * noise()};
    sample.has_accel = true;
    recording.imu.push_back(sample);
  }
  return recording;
}

template <typename Edit>
Recording Edited(Edit edit) {
  Recording recording = Drive();
  for (ImuSample& sample : recording.imu) edit(sample);
  return recording;
}

// What the check says about it.
std::string Check(Recording& recording, const ImuCheckOptions& options = {}) {
  CheckImu(options, recording);
  return AllText(recording.warnings);
}

double GyroEnergy(const Recording& recording) {
  double sum = 0;
  for (const ImuSample& sample : recording.imu) sum += sample.w_I_rad_s.squaredNorm();
  return sum;
}

TEST(ImuCheck, ASoundImuIsLeftAsItIs) {
  Recording recording = Drive();
  EXPECT_THAT(Check(recording), IsEmpty());
  const Recording before = Drive();
  ASSERT_EQ(recording.imu.size(), before.imu.size());
  for (size_t i = 0; i < before.imu.size(); ++i) {
    ASSERT_EQ(recording.imu[i].w_I_rad_s, before.imu[i].w_I_rad_s);
    ASSERT_EQ(recording.imu[i].a_I_m_s2, before.imu[i].a_I_m_s2);
    ASSERT_TRUE(recording.imu[i].has_accel);
  }
}

// Wheels that tell turns three times too large, or a third of them, change no verdict.
TEST(ImuCheck, GyroInDegreesIsConvertedWhateverTheTrackOfTheWheels) {
  for (const double track_factor : {0.33, 1.0, 3.0}) {
    SCOPED_TRACE(track_factor);
    for (const bool degrees : {false, true}) {
      Recording recording = Edited([&](ImuSample& s) {
        if (degrees) s.w_I_rad_s *= 180 / M_PI;
      });
      for (WheelSample& sample : recording.wheel) sample.dyaw_rad *= track_factor;
      const std::string said = Check(recording);
      if (degrees) {
        EXPECT_THAT(said, AllOf(HasSubstr("gyro is in deg/s"), HasSubstr("converted")));
      } else {
        EXPECT_THAT(said, IsEmpty());
      }
      EXPECT_NEAR(GyroEnergy(recording), GyroEnergy(Drive()), 1e-6);
    }
  }
}

TEST(ImuCheck, WithoutTurnsOnlyAnImpossibleRateTellsDegrees) {
  Recording still = Drive();
  for (WheelSample& sample : still.wheel) sample.dyaw_rad = 0;
  for (ImuSample& sample : still.imu) sample.w_I_rad_s.setConstant(0.01);
  EXPECT_THAT(Check(still), IsEmpty());
  Recording fast = Edited([](ImuSample& s) { s.w_I_rad_s *= 100; });
  fast.wheel.clear();
  EXPECT_THAT(Check(fast), HasSubstr("gyro is in deg/s (it reaches"));
}

TEST(ImuCheck, AStatedUnitIsTaken) {
  Recording degrees = Edited([](ImuSample& s) { s.w_I_rad_s *= 180 / M_PI; });
  ImuCheckOptions options;
  options.gyro_unit = GyroUnit::kDegPerS;
  EXPECT_THAT(Check(degrees, options), HasSubstr("deg/s (as stated)"));
  EXPECT_NEAR(GyroEnergy(degrees), GyroEnergy(Drive()), 1e-6);
  options.gyro_unit = GyroUnit::kRadPerS;
  Recording wrong = Edited([](ImuSample& s) { s.w_I_rad_s *= 180 / M_PI; });
  EXPECT_THAT(Check(wrong, options), HasSubstr("is its unit as stated?"));
}

TEST(ImuCheck, AxesThatDoNotFitAreNamed) {
  Recording reversed = Edited([](ImuSample& s) { s.w_I_rad_s.z() *= -1; });
  EXPECT_THAT(Check(reversed), HasSubstr("gyro turns against the wheels"));
  Recording exchanged = Edited([](ImuSample& s) {
    s.w_I_rad_s = {s.w_I_rad_s.x(), -s.w_I_rad_s.z(), s.w_I_rad_s.y()};
  });
  EXPECT_THAT(Check(exchanged), HasSubstr("does not follow the turns of the wheels; they are on "
                                          "its -y axis"));
}

TEST(ImuCheck, AccelerometerInGIsConverted) {
  for (const double unit : {1.0, 0.001}) {
    SCOPED_TRACE(unit);
    Recording recording = Edited([&](ImuSample& s) { s.a_I_m_s2 /= 9.80665 * unit; });
    EXPECT_THAT(Check(recording), HasSubstr(unit == 1 ? "is in g (" : "is in mg ("));
    EXPECT_NEAR(recording.imu[10].a_I_m_s2.z(), Drive().imu[10].a_I_m_s2.z(), 1e-9);
  }
}

TEST(ImuCheck, AccelerometersThatShowNoGravityAreLeftOut) {
  Recording removed = Edited([](ImuSample& s) { s.a_I_m_s2.z() -= kGravity; });
  EXPECT_THAT(Check(removed), HasSubstr("shows no gravity"));
  EXPECT_FALSE(removed.imu[0].has_accel);
  EXPECT_EQ(removed.imu.size(), 6000u);  // the gyro stays
  Recording feet = Edited([](ImuSample& s) { s.a_I_m_s2 /= 0.3048; });
  EXPECT_THAT(Check(feet), HasSubstr("neither in m/s^2 nor in g"));
  EXPECT_FALSE(feet.imu[0].has_accel);
}

TEST(ImuCheck, OnWheelsTheBodyIsUpright) {
  Recording gravity = Edited([](ImuSample& s) { s.a_I_m_s2 *= -1; });
  EXPECT_THAT(Check(gravity), HasSubstr("shows gravity, not specific force"));
  EXPECT_GT(gravity.imu[0].a_I_m_s2.z(), 9);
  Recording lying = Edited([](ImuSample& s) {
    s.a_I_m_s2 = {s.a_I_m_s2.z(), s.a_I_m_s2.y(), s.a_I_m_s2.x()};
  });
  EXPECT_THAT(Check(lying), HasSubstr("90 deg away from the body's z"));
  EXPECT_FALSE(lying.imu[0].has_accel);
}

TEST(ImuCheck, AnotherClockIsNamedWithItsOffsetWhichMendsIt) {
  for (const double offset_s : {3600.0, -7.3, 4.2}) {
    SCOPED_TRACE(offset_s);
    const auto shifted = [&] {
      return Edited([&](ImuSample& s) { s.utime = s.utime + DurationFromSeconds(offset_s); });
    };
    Recording recording = shifted();
    char text[40];
    std::snprintf(text, sizeof text, "--imu-time-offset %.2f", offset_s);
    EXPECT_THAT(Check(recording), AllOf(HasSubstr(text), HasSubstr("the IMU is left out")));
    EXPECT_TRUE(recording.imu.empty());
    ImuCheckOptions options;
    options.time_offset_s = offset_s;
    Recording mended = shifted();
    EXPECT_THAT(Check(mended, options), IsEmpty());
    ASSERT_EQ(mended.imu.size(), 6000u);
    EXPECT_EQ(mended.imu[0].utime, kBegin);
  }
}

TEST(ImuCheck, GroundTruthServesWhereThereAreNoWheels) {
  Recording recording = Edited([](ImuSample& s) { s.w_I_rad_s *= 180 / M_PI; });
  SE3 T_GB;
  for (const WheelSample& sample : recording.wheel) {
    T_GB = T_GB * SE3(ExpSO3({0, 0, sample.dyaw_rad}), {sample.dx_m, 0, 0});
    GroundTruth truth;
    truth.utime = sample.utime;
    truth.T_GB = T_GB;
    recording.ground_truth.push_back(truth);
  }
  recording.wheel.clear();
  EXPECT_THAT(Check(recording), HasSubstr("times as much as the ground truth"));
}

TEST(OrderImu, RepeatedTimesAreCountedAndAStreamOfThemIsLeftOut) {
  std::vector<std::string> warnings;
  std::vector<ImuSample> some = Drive().imu;
  some[5].utime = some[4].utime;
  OrderImu(some, "imu.txt", warnings);
  EXPECT_EQ(some.size(), 5999u);
  EXPECT_THAT(AllText(warnings), HasSubstr("imu.txt: 1 of 6000 records repeat a time"));
  std::vector<ImuSample> batches = Drive().imu;
  for (size_t i = 0; i < batches.size(); ++i) batches[i].utime = batches[i - i % 4].utime;
  warnings.clear();
  OrderImu(batches, "imu.txt", warnings);
  EXPECT_TRUE(batches.empty());
  EXPECT_THAT(AllText(warnings),
              AllOf(HasSubstr("4500 of 6000 records repeat"), HasSubstr("IMU is left out")));
}

}  // namespace
}  // namespace gw::importer

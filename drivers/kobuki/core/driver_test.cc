// Tests of the driver against the emulated base: odometry, gyro, faults, safety, what it sends.
#include "drivers/kobuki/core/driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "drivers/kobuki/test/driver_rig.h"

namespace gw::kobuki {
namespace {

using testing::HasSubstr;

struct Planar {
  double x = 0, y = 0, yaw = 0;
};

Planar Integrate(const std::vector<WheelSample>& samples) {
  Planar p;
  for (const WheelSample& s : samples) {
    p.x += std::cos(p.yaw) * s.dx_m - std::sin(p.yaw) * s.dy_m;
    p.y += std::sin(p.yaw) * s.dx_m + std::cos(p.yaw) * s.dy_m;
    p.yaw += s.dyaw_rad;
  }
  return p;
}

// The base drives a curvy way through several wraps of the encoders (5.59 m) and of the clock (65.5
// s).
TEST(KobukiDriver, OdometryFollowsTheBaseThroughAllWraps) {
  EmulatorConfig robot;
  robot.first_timestamp_ms = 60000;
  robot.first_left_ticks = 65500;
  robot.first_right_ticks = 40;
  DriverRig rig(robot);
  rig.Run(2);
  rig.Run(150, [](Utime now) {
    return Twist{0.4, 0.6 * std::sin(static_cast<double>(now.us) * 2e-7)};
  });
  rig.Run(3);
  const Planar p = Integrate(rig.wheel);
  EXPECT_NEAR(p.x, rig.emulator.x_m(), 0.002);
  EXPECT_NEAR(p.y, rig.emulator.y_m(), 0.002);
  EXPECT_NEAR(p.yaw, rig.emulator.yaw_rad(), 0.002);
  EXPECT_GT(std::hypot(p.x, p.y) + rig.Counter("frames"), 7000);
  EXPECT_EQ(rig.Counter("restarts"), 0);
  EXPECT_EQ(rig.Counter("corrupt_frames"), 0);
  EXPECT_TRUE(rig.wheel.back().has_heading);
  EXPECT_NEAR(
      std::remainder(rig.wheel.back().heading_rad - rig.emulator.yaw_rad(), 2 * std::numbers::pi),
      0, 0.001);
}

TEST(KobukiDriver, LostFramesLoseNoMotion) {
  EmulatorConfig robot;
  robot.drop_byte = 2e-3;
  robot.flip_bit = 5e-4;
  robot.garbage_burst = 0.05;
  robot.unknown_sub_payload = 0.1;
  robot.duplicate_timestamp = 0.02;
  robot.latency_timer = Milliseconds(16);
  DriverRig rig(robot);
  rig.Run(1);
  rig.Run(120, Twist{0.3, 0.2});
  rig.Run(3);
  EXPECT_GT(rig.Counter("bad_checksum"), 100);
  EXPECT_GT(rig.Counter("unknown_sub_payload"), 100);
  EXPECT_GT(rig.Counter("duplicate_frames"), 20);
  const Planar p = Integrate(rig.wheel);
  EXPECT_NEAR(p.x, rig.emulator.x_m(), 0.01);
  EXPECT_NEAR(p.y, rig.emulator.y_m(), 0.01);
  EXPECT_NEAR(p.yaw, rig.emulator.yaw_rad(), 0.01);
}

TEST(KobukiDriver, RebootMakesNoMotionAndIsCounted) {
  DriverRig rig;
  rig.Run(1);
  rig.Run(8, Twist{0.5, 0.1});
  const size_t before = rig.wheel.size();
  rig.emulator.Reboot();
  rig.Run(3);
  EXPECT_EQ(rig.Counter("reboots"), 1);
  ASSERT_GT(rig.wheel.size(), before + 50);
  for (size_t i = before; i < rig.wheel.size(); ++i) {
    EXPECT_LT(std::abs(rig.wheel[i].dx_m), 0.02);
  }
  EXPECT_EQ(rig.wheel.back().seq, static_cast<int64_t>(rig.wheel.size()));
  // The base is asked again who it is, and told again what its outputs are.
  EXPECT_TRUE(rig.driver.identity().complete());
  EXPECT_EQ(rig.emulator.output() & 0x00F0, 0x00F0);
}

TEST(KobukiDriver, LongSilenceMakesAGapAndNoMotion) {
  DriverRig rig;
  rig.Run(1);
  rig.Run(3, Twist{0.5, 0});
  rig.emulator.SetSilent(true);
  rig.Run(10);
  EXPECT_EQ(rig.driver.GetCondition(rig.now()).state, HealthState::kDegraded);
  EXPECT_THAT(rig.driver.GetCondition(rig.now()).message, HasSubstr("switched on"));
  const size_t before = rig.wheel.size();
  rig.emulator.SetSilent(false);
  rig.Run(2);
  ASSERT_GT(rig.wheel.size(), before + 20);
  EXPECT_GT(rig.wheel[before].utime_begin, rig.wheel[before - 1].utime);  // a visible gap
  EXPECT_LT(rig.wheel[before].dx_m, 0.02);
  EXPECT_EQ(rig.Counter("reboots"), 0);
  EXPECT_EQ(rig.Counter("restarts"), 1);
}

TEST(KobukiDriver, IdentityIsLearntInEveryForm) {
  for (const bool own_frame : {false, true}) {
    for (const VersionForm form : {VersionForm::kFourBytes, VersionForm::kTwoBytes}) {
      EmulatorConfig robot;
      robot.answers_in_own_frame = own_frame;
      robot.version_form = form;
      robot.firmware = {1, 1, 1};
      DriverRig rig(robot);
      rig.Run(2);
      EXPECT_EQ(rig.driver.identity().hardware, (Version{1, 0, 4}));
      EXPECT_EQ(rig.driver.identity().firmware, (Version{1, 1, 1}));
      EXPECT_EQ(rig.driver.identity().udid, robot.udid);
      EXPECT_THAT(rig.driver.GetCondition(rig.now()).message, HasSubstr("update to 1.2.0"));
    }
  }
}

TEST(KobukiDriver, UnknownFirmwareIsNotDriven) {
  EmulatorConfig robot;
  robot.firmware = {2, 0, 0};
  DriverRig rig(robot);
  rig.Run(4, Twist{0.3, 0});
  EXPECT_EQ(rig.driver.GetCondition(rig.now()).state, HealthState::kFailed);
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
  EXPECT_GT(rig.wheel.size(), 100u);
}

TEST(KobukiDriver, SendsNothingToWhatIsNoKobuki) {
  Driver driver{KobukiConfig{}, WheelCalibration{}};
  driver.PortOpened(Utime{0});
  for (int64_t ms = 0; ms < 3000; ms += 5) {
    const Utime now{1000 * ms};
    driver.Command({now, 1, 0.3, 0}, now);
    driver.Receive(std::vector<uint8_t>(10, static_cast<uint8_t>('$')), now);
    EXPECT_TRUE(driver.Tick(now).empty());
  }
}

TEST(KobukiDriver, AccelerationIsLimitedAndCommandsTimeOut) {
  KobukiConfig config;
  config.accel_m_s2 = 0.5;
  config.decel_m_s2 = 1.0;
  DriverRig rig({}, config);
  rig.Run(1);
  rig.Run(0.5, Twist{0.6, 0});
  EXPECT_NEAR(rig.driver.driving().v_m_s, 0.25, 0.03);
  rig.Run(2, Twist{0.6, 0});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0.6);
  EXPECT_NEAR(rig.emulator.v_m_s(), 0.6, 0.01);
  // The last command is up to 50 ms old here.
  rig.Run(0.24);
  EXPECT_EQ(rig.driver.driving().v_m_s, 0.6);
  rig.Run(0.1);
  EXPECT_LT(rig.driver.driving().v_m_s, 0.6);
  rig.Run(0.7);
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
}

TEST(KobukiDriver, SpeedLimitKeepsTheCurve) {
  KobukiConfig config;
  config.max_speed_m_s = 0.2;
  DriverRig rig({}, config);
  rig.Run(4, Twist{0.6, 0.9});
  EXPECT_NEAR(rig.driver.driving().v_m_s, 0.2, 1e-9);
  EXPECT_NEAR(rig.driver.driving().w_rad_s, 0.3, 1e-9);
}

TEST(KobukiDriver, StaleFutureAndBrokenCommandsAreRefused) {
  DriverRig rig;
  rig.Run(1);
  const double nan = std::nan("");
  rig.driver.Command({rig.now() - Milliseconds(400), 1, 0.3, 0}, rig.now());
  rig.driver.Command({rig.now() + Milliseconds(400), 2, 0.3, 0}, rig.now());
  rig.driver.Command({rig.now(), 3, nan, 0}, rig.now());
  rig.driver.Command({rig.now(), 4, 0, INFINITY}, rig.now());
  rig.Run(0.2);
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
  EXPECT_EQ(rig.Counter("commands_refused"), 4);
}

TEST(KobukiSafety, BumperStopsForwardMotionUntilTheSenderBacksOff) {
  DriverRig rig;
  rig.Run(1);
  rig.Run(2, Twist{0.3, 0});
  rig.emulator.SetContact(kCentreBit, 0, 0);
  rig.Run(0.1, Twist{0.3, 0});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);  // at once, not by the ramp
  EXPECT_TRUE(rig.wheel.back().contact.bumper);
  EXPECT_EQ(rig.emulator.output() & 0x0300, 0x0100);  // LED 1 red
  EXPECT_THAT(rig.driver.GetCondition(rig.now()).message, HasSubstr("bumper"));
  // The block could end now, but the sender still pushes forward: it has not noticed.
  rig.emulator.SetContact(0, 0, 0);
  rig.Run(2, Twist{0.3, 0.5});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
  EXPECT_EQ(rig.driver.driving().w_rad_s, 0);
  rig.Run(0.5, Twist{-0.1, 0});
  EXPECT_LT(rig.driver.driving().v_m_s, 0);
  rig.Run(2, Twist{0.3, 0});
  EXPECT_NEAR(rig.driver.driving().v_m_s, 0.3, 1e-9);
  EXPECT_EQ(rig.Counter("safety_stops"), 1);
}

TEST(KobukiSafety, CliffLetsTheBaseBackOffAndTurnOnly) {
  DriverRig rig;
  rig.Run(1);
  rig.emulator.SetContact(0, 0, kLeftBit);
  rig.Run(1, Twist{0.2, 0.3});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
  EXPECT_EQ(rig.driver.driving().w_rad_s, 0);
  rig.Run(1, Twist{0, -0.5});
  EXPECT_NEAR(rig.driver.driving().w_rad_s, -0.5, 1e-9);
  rig.Run(1, Twist{-0.2, 0});
  EXPECT_NEAR(rig.driver.driving().v_m_s, -0.2, 1e-9);
  rig.Run(1, Twist{0.2, 0});  // there is still no floor
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
}

TEST(KobukiSafety, CarriedBaseDoesNotDriveOffWhenPutDown) {
  DriverRig rig;
  rig.Run(1);
  rig.Run(1, Twist{0.3, 0});
  rig.emulator.SetContact(0, kLeftWheelDropBit, 0);
  rig.Run(0.1, Twist{-0.3, 1});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
  EXPECT_EQ(rig.driver.driving().w_rad_s, 0);
  rig.Run(1, Twist{0, 0});  // a stop while it hangs does not count
  rig.Run(0.2, Twist{0.3, 0});
  rig.emulator.SetContact(0, 0, 0);
  rig.Run(3, Twist{0.3, 0});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
  rig.Run(0.4);  // silence counts as a stop
  rig.Run(1, Twist{0.3, 0});
  EXPECT_NEAR(rig.driver.driving().v_m_s, 0.3, 1e-9);
}

TEST(KobukiSafety, BlindBaseIsToldToStop) {
  DriverRig rig;
  rig.Run(1);
  rig.Run(2, Twist{0.3, 0});
  rig.emulator.SetSilent(true);
  rig.Run(0.3, Twist{0.3, 0});
  EXPECT_EQ(rig.driver.driving().v_m_s, 0);
}

TEST(KobukiSafety, ContactBetweenSamplesIsNotLost) {
  DriverRig rig;
  rig.Run(1);
  rig.emulator.SetContact(kLeftBit, 0, 0);
  rig.Run(0.04);
  rig.emulator.SetContact(0, 0, 0);
  rig.Run(0.2);
  EXPECT_TRUE(std::any_of(rig.wheel.begin(), rig.wheel.end(),
                          [](const auto& s) { return s.contact.bumper; }));
  EXPECT_FALSE(rig.wheel.back().contact.bumper);
}

TEST(KobukiGyro, BiasIsLearntAtRestAndOnlyAtRest) {
  DriverRig rig;
  rig.Run(10);
  const auto mean_z = [&](size_t begin) {
    double sum = 0;
    for (size_t i = begin; i < rig.imu.size(); ++i) sum += rig.imu[i].w_I_rad_s.z();
    return sum / static_cast<double>(rig.imu.size() - begin);
  };
  ASSERT_GT(rig.imu.size(), 800u);
  EXPECT_NEAR(mean_z(0), 0, 0.005);
  EXPECT_NEAR(mean_z(500), 0, 3e-4);
  EXPECT_FALSE(rig.imu.back().has_accel);
  // A steady turn is not taken for a bias.
  rig.Run(10, Twist{0, 0.5});
  const size_t turning = rig.imu.size() - 300;
  EXPECT_NEAR(mean_z(turning), rig.emulator.w_rad_s(), 0.001);
  // A base that is turned by hand shows no bias either: its wheels are still and its gyro is not.
  StationaryBias bias;
  for (int i = 0; i < 1000; ++i) bias.Add({0, 0, 0.5}, true);
  EXPECT_FALSE(bias.known());
}

TEST(KobukiGyro, AxesAreThoseOfTheBody) {
  // This is the worked example of the protocol, in deg/s.
  const Eigen::Vector3d w = GyroRate({10, -20, 30}) * 180 / std::numbers::pi;
  EXPECT_NEAR(w.x(), 0.175, 1e-12);
  EXPECT_NEAR(w.y(), 0.0875, 1e-12);
  EXPECT_NEAR(w.z(), 0.2625, 1e-12);
}

TEST(KobukiBattery, StateReachesHealthAndLeds) {
  DriverRig rig;
  rig.Run(2);
  EXPECT_EQ(rig.driver.GetCondition(rig.now()).state, HealthState::kOk);
  EXPECT_EQ(rig.Counter("battery_mv"), 16300);
  EXPECT_EQ(rig.emulator.output(), 0x0BF0);  // LED 1 orange: no command; LED 2 green
  rig.emulator.SetBattery(138, 0);
  rig.Run(1);
  EXPECT_THAT(rig.driver.GetCondition(rig.now()).message, HasSubstr("battery low"));
  EXPECT_EQ(rig.emulator.output() & 0x0C00, 0x0C00);
  rig.emulator.SetBattery(130, 0);
  rig.Run(1);
  EXPECT_THAT(rig.driver.GetCondition(rig.now()).message, HasSubstr("charge now"));
  rig.emulator.SetBattery(130, 22);
  rig.Run(1);
  EXPECT_EQ(rig.driver.GetCondition(rig.now()).state, HealthState::kOk);
  EXPECT_EQ(rig.Counter("charging"), 1);
  EXPECT_TRUE(rig.driver.battery().from_adapter);
  EXPECT_NEAR(ReadBattery(165, 0).percent, 100, 1e-9);
  EXPECT_NEAR(ReadBattery(132, 0).percent, 5, 1e-9);
}

// The stream has far more damage than any cable gives; every frame that comes through is still a
// possible one.
TEST(KobukiDriver, HostileStreamNeverBecomesImpossibleMotion) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    CounterRng rng(seed, 3, 0);
    EmulatorConfig robot;
    robot.seed = seed;
    robot.drop_byte = rng.Uniform(0, 0.01);
    robot.flip_bit = rng.Uniform(0, 0.02);
    robot.garbage_burst = rng.Uniform(0, 0.5);
    robot.duplicate_timestamp = rng.Uniform(0, 0.2);
    robot.unknown_sub_payload = rng.Uniform(0, 0.5);
    robot.stall_rate_hz = rng.Uniform(0, 5);
    robot.latency_timer = Milliseconds(16);
    DriverRig rig(robot);
    for (int i = 0; i < 10; ++i) {
      rig.Run(rng.Uniform(0.2, 6), Twist{rng.Uniform(-0.6, 0.6), rng.Uniform(-1, 1)});
      if (rng.Below(4) == 0) rig.emulator.Reboot();
      rig.emulator.SetSilent(rng.Below(5) == 0);
    }
    rig.emulator.SetSilent(false);
    rig.Run(5);
    ASSERT_GT(rig.wheel.size(), 100u) << seed;
    for (size_t i = 0; i < rig.wheel.size(); ++i) {
      const WheelSample& s = rig.wheel[i];
      ASSERT_EQ(s.seq, static_cast<int64_t>(i) + 1);
      ASSERT_GT(s.utime, s.utime_begin);
      if (i > 0) {
        ASSERT_GE(s.utime_begin, rig.wheel[i - 1].utime);
      }
      // The limit on ticks is 1.07 m/s, and for each interval the ticks of 20 ms more.
      const double most = 1.1 * (s.utime - s.utime_begin).seconds() + 0.03;
      ASSERT_LT(std::hypot(s.dx_m, s.dy_m), most) << "seed " << seed << " sample " << i;
    }
    for (size_t i = 1; i < rig.imu.size(); ++i) {
      ASSERT_GT(rig.imu[i].utime, rig.imu[i - 1].utime);
      ASSERT_TRUE(rig.imu[i].w_I_rad_s.allFinite());
    }
  }
}

TEST(KobukiDriver, RandomBytesAndTimesHarmNothing) {
  Driver driver{KobukiConfig{}, WheelCalibration{}};
  driver.PortOpened(Utime{0});
  Utime now{0};
  int64_t samples = 0;
  for (uint64_t i = 0; i < 40'000; ++i) {
    CounterRng rng(4, 1, i);
    // These are valid frames of nonsense, so that what is behind the checksum is reached.
    BasicData basic{
        .timestamp_ms = static_cast<uint16_t>(i * 20 + rng.Below(3)),
        .bumper = static_cast<uint8_t>(rng.Below(256)),
        .left_encoder = static_cast<uint16_t>(rng.Below(rng.Below(3) == 0 ? 65536 : 99)),
        .charger = static_cast<uint8_t>(rng.Below(256)),
        .battery_dv = static_cast<uint8_t>(rng.Below(256))};
    if (rng.Below(50) == 0) basic.timestamp_ms = static_cast<uint16_t>(rng.Below(65536));
    Feedback feedback;
    feedback.basic = basic;
    feedback.inertial = Inertial{static_cast<int16_t>(rng.Below(65536)), 0};
    feedback.raw_gyro = RawGyro{static_cast<uint8_t>(rng.Below(256)), {{32767, -32768, 1}}};
    if (rng.Below(9) == 0) {
      feedback.firmware = Version{static_cast<int>(rng.Below(256)), 0, 255};
      feedback.hardware = Version{255, 255, 255};
    }
    auto bytes = EncodeFrame(EncodeFeedback(feedback));
    if (rng.Below(3) == 0) bytes[rng.Below(static_cast<uint32_t>(bytes.size()))] ^= 0x10;
    now = now +
          DurationUs{static_cast<int64_t>(rng.Below(rng.Below(100) == 0 ? 90'000'000 : 40'000))};
    const auto out = driver.Receive(bytes, now);
    samples += static_cast<int64_t>(out.wheel.size() + out.imu.size());
    driver.Command({now, 1, rng.Uniform(-1e9, 1e9), rng.Uniform(-1e9, 1e9)}, now);
    driver.Tick(now);
    driver.GetCondition(now);
    driver.Counters();
  }
  EXPECT_GT(samples, 100);
}

TEST(KobukiDriver, CountersAreSortedByName) {
  const Driver driver{KobukiConfig{}, WheelCalibration{}};
  const auto counters = driver.Counters();
  EXPECT_TRUE(std::is_sorted(counters.begin(), counters.end()));
}

TEST(KobukiDriver, SameRunGivesTheSameSamples) {
  EmulatorConfig robot;
  robot.drop_byte = 1e-3;
  robot.stall_rate_hz = 1;
  DriverRig a(robot);
  DriverRig b(robot);
  a.Run(20, Twist{0.2, 0.4});
  b.Run(20, Twist{0.2, 0.4});
  ASSERT_EQ(a.wheel.size(), b.wheel.size());
  for (size_t i = 0; i < a.wheel.size(); ++i) {
    EXPECT_EQ(a.wheel[i].utime, b.wheel[i].utime);
    EXPECT_EQ(a.wheel[i].dx_m, b.wheel[i].dx_m);
  }
}

}  // namespace
}  // namespace gw::kobuki

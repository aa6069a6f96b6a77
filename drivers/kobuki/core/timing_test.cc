// Tests of measurement times: what delivery does to arrivals must not reach the samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/kobuki/test/driver_rig.h"

namespace gw::kobuki {
namespace {

struct Delivery {
  const char* name;
  EmulatorConfig config;
};

EmulatorConfig With(const std::function<void(EmulatorConfig*)>& change) {
  EmulatorConfig config;
  change(&config);
  return config;
}

std::vector<Delivery> Deliveries() {
  return {
      {"latency_timer_1_ms", EmulatorConfig{}},
      {"latency_timer_16_ms", With([](auto* c) { c->latency_timer = Milliseconds(16); })},
      {"timer_16_ms_fast_clock", With([](auto* c) {
         c->latency_timer = Milliseconds(16);
         c->clock_ppm = 80;
       })},
      {"timer_16_ms_slow_clock", With([](auto* c) {
         c->latency_timer = Milliseconds(16);
         c->clock_ppm = -80;
       })},
      {"host_jitter_3_ms", With([](auto* c) { c->host_jitter = Milliseconds(3); })},
      {"stalls_of_60_ms", With([](auto* c) {
         c->latency_timer = Milliseconds(16);
         c->stall_rate_hz = 2;
       })},
      {"bytes_dropped", With([](auto* c) {
         c->latency_timer = Milliseconds(16);
         c->drop_byte = 1e-3;
       })},
      {"across_the_16_bit_wraps", With([](auto* c) {
         c->first_timestamp_ms = 65000;
         c->first_left_ticks = 65000;
         c->first_right_ticks = 64000;
       })},
  };
}

class KobukiTiming : public testing::TestWithParam<Delivery> {};

// The base drives straight ahead, so that every frame has ticks of its own.
TEST_P(KobukiTiming, WheelTimesAreThoseOfTheMeasurementWithin2Ms) {
  DriverRig rig(GetParam().config);
  rig.Run(60, Twist{0.3, 0.02});
  double worst = 0;
  double sum = 0;
  int count = 0;
  for (const WheelSample& sample : rig.wheel) {
    if (sample.utime - GetParam().config.start < Milliseconds(3000)) continue;
    const auto error = rig.TimeError(sample, {0});
    ASSERT_TRUE(error) << sample.seq;
    worst = std::max(worst, std::abs(error->seconds()));
    sum += error->seconds();
    ++count;
  }
  ASSERT_GT(count, 2000);
  EXPECT_LT(worst, 0.002);
  RecordProperty("worst_ms", std::to_string(1e3 * worst));
  RecordProperty("mean_ms", std::to_string(1e3 * sum / count));
  std::printf("%s: %d samples, worst %.2f ms, mean %.2f ms, longest wait %.1f ms\n",
              GetParam().name, count, 1e3 * worst, 1e3 * sum / count,
              1e3 * rig.driver.worst_wait().seconds());
}

TEST_P(KobukiTiming, SamplesAreInOrderWithoutGapsInSeq) {
  DriverRig rig(GetParam().config);
  rig.Run(30, Twist{0.2, 0.3});
  ASSERT_GT(rig.wheel.size(), 1000u);
  for (size_t i = 1; i < rig.wheel.size(); ++i) {
    EXPECT_EQ(rig.wheel[i].seq, rig.wheel[i - 1].seq + 1);
    EXPECT_EQ(rig.wheel[i].utime_begin, rig.wheel[i - 1].utime);
    EXPECT_GT(rig.wheel[i].utime, rig.wheel[i].utime_begin);
  }
  ASSERT_GT(rig.imu.size(), 2000u);
  for (size_t i = 1; i < rig.imu.size(); ++i) {
    EXPECT_EQ(rig.imu[i].seq, rig.imu[i - 1].seq + 1);
    EXPECT_GT(rig.imu[i].utime, rig.imu[i - 1].utime);
  }
}

// The gyro's rate and phase are not told by the base.
TEST_P(KobukiTiming, GyroTimesAreThoseOfTheMeasurementWithin4Ms) {
  DriverRig rig(GetParam().config);
  rig.Run(40, Twist{0.1, 0.3});
  const auto& truth = rig.emulator.gyro();
  double worst = 0;
  int count = 0;
  for (const ImuSample& sample : rig.imu) {
    if (sample.utime - GetParam().config.start < Milliseconds(5000)) continue;
    const auto after =
        std::lower_bound(truth.begin(), truth.end(), sample.utime,
                         [](const auto& t, Utime utime) { return t.measured < utime; });
    ASSERT_NE(after, truth.end());
    ASSERT_NE(after, truth.begin());
    worst = std::max(worst, std::min((after->measured - sample.utime).seconds(),
                                     (sample.utime - (after - 1)->measured).seconds()));
    ++count;
  }
  ASSERT_GT(count, 3000);
  EXPECT_LT(worst, 0.004);
  std::printf("%s: %d gyro samples, worst distance %.2f ms\n", GetParam().name, count, 1e3 * worst);
}

INSTANTIATE_TEST_SUITE_P(Deliveries, KobukiTiming, testing::ValuesIn(Deliveries()),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(KobukiTransportDelay, ConstantDelayIsReportedAndStaysUnlessConfigured) {
  EmulatorConfig robot;
  robot.transport_delay = Milliseconds(47);
  for (const double configured_ms : {0.0, 47.0}) {
    KobukiConfig config;
    config.transport_delay_ms = configured_ms;
    DriverRig rig(robot, config);
    rig.Run(60, Twist{0.3, 0.02});
    const DurationUs left = DurationFromSeconds(0.047 - 1e-3 * configured_ms);
    double worst = 0;
    for (const WheelSample& sample : rig.wheel) {
      if (sample.utime - robot.start < Milliseconds(3000)) continue;
      const auto error = rig.TimeError(sample, left);
      ASSERT_TRUE(error);
      worst = std::max(worst, std::abs(error->seconds()));
    }
    EXPECT_LT(worst, 0.002);
    // The round trip is an upper bound that a minute of requests brings close.
    EXPECT_GE(rig.driver.round_trip(), Milliseconds(47));
    EXPECT_LE(rig.driver.round_trip(), Milliseconds(57));
    std::printf("configured %.0f ms: worst %.2f ms, round trip %.1f ms\n", configured_ms,
                1e3 * worst, 1e3 * rig.driver.round_trip().seconds());
  }
}

}  // namespace
}  // namespace gw::kobuki

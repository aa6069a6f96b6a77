#include "drivers/common/device_clock.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"

namespace gw {
namespace {

TEST(LowerEnvelope, FindsOffsetAndSlopeUnderNoise) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 1, 0);
    const double slope = rng.Uniform(-1e-4, 1e-4);
    LowerEnvelope envelope({.bin = 250'000, .num_bins = 120, .max_slope = 2e-4});
    double y = 0;
    int64_t x = 0;
    for (int i = 0; i < 3000; ++i) {
      x += 20'000;
      y = 7e11 + slope * static_cast<double>(x);
      envelope.Add(x, std::llround(y - 5e3 * std::log(1 - rng.Uniform())));
    }
    EXPECT_NEAR(envelope.At(x), y, 700) << seed;  // waits are 5000 on average
  }
}

TEST(LowerEnvelope, SlopeIsBoundedWhateverThePoints) {
  LowerEnvelope envelope({.bin = 10, .num_bins = 10, .max_slope = 0.1});
  envelope.Add(0, 0);
  envelope.Add(10, -1000);
  EXPECT_NEAR(envelope.At(110) - envelope.At(10), -10, 1e-9);
}

TEST(DeviceClock, SteppedHostClockIsFollowedWithinSeconds) {
  DeviceClock clock;
  Utime step{0};
  int64_t device_us = 0;
  const auto run = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      device_us += 20'000;
      clock.Add(device_us, Utime{5'000'000'000} + DurationUs{device_us} + (step - Utime{0}));
    }
    return (clock.ToHost(device_us) - Utime{5'000'000'000} - DurationUs{device_us}).us;
  };
  EXPECT_EQ(run(500), 0);
  step = Utime{2'000'000};
  EXPECT_EQ(run(150), 2'000'000);
  step = Utime{-3'000'000};
  EXPECT_EQ(run(2), -3'000'000);
  EXPECT_EQ(clock.steps(), 2);
}

}  // namespace
}  // namespace gw

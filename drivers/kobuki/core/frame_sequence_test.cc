#include "drivers/kobuki/core/frame_sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "drivers/kobuki/core/odometry.h"

namespace gw::kobuki {
namespace {

using Verdict = FrameSequence::Verdict;

FrameStamp At(int64_t ms, uint16_t ticks = 0) {
  return {static_cast<uint16_t>(ms), ticks, ticks, Utime{1000 * (ms + 700'000)}};
}

// A sequence of frames that has settled at `ms`.
FrameSequence Running(int64_t ms) {
  FrameSequence s;
  EXPECT_EQ(s.Judge(At(ms - 20)).verdict, Verdict::kHeld);
  EXPECT_EQ(s.Judge(At(ms)).verdict, Verdict::kRestarts);
  return s;
}

TEST(FrameSequence, ClockUnwrapsOverManyTurns) {
  FrameSequence s = Running(65'000);
  for (int64_t ms = 65'020; ms < 400'000; ms += 20) {
    const auto j = s.Judge(At(ms));
    ASSERT_EQ(j.verdict, Verdict::kContinues);
    ASSERT_EQ(j.robot_us, 1000 * (ms - 65'000));
  }
}

TEST(FrameSequence, OneCorruptFrameIsDroppedAndNothingElseHappens) {
  const FrameStamp corrupt[] = {
      {40'000, 0, 0, Utime{1000 * (10'020 + 700'000)}},       // time
      {10'020, 16'384, 0, Utime{1000 * (10'020 + 700'000)}},  // left encoder
      {10'020, 0, 64'000, Utime{1000 * (10'020 + 700'000)}},  // right encoder
  };
  for (const FrameStamp& stamp : corrupt) {
    FrameSequence s = Running(10'000);
    EXPECT_EQ(s.Judge(stamp).verdict, Verdict::kHeld);
    const auto j = s.Judge(At(10'040));
    EXPECT_EQ(j.verdict, Verdict::kContinues);
    EXPECT_EQ(j.robot_us, 40'000);
    EXPECT_EQ(s.corrupt(), 1);
    EXPECT_EQ(s.restarts(), 0);
  }
}

TEST(FrameSequence, GapsKeepTheClockAndRebootsDoNot) {
  for (const int64_t gap : {4'000, 40'000, 70'000, 200'000}) {
    FrameSequence s = Running(10'000);
    EXPECT_EQ(s.Judge(At(10'000 + gap, 30'000)).verdict, Verdict::kHeld);
    const auto j = s.Judge(At(10'020 + gap, 30'000));
    EXPECT_EQ(j.verdict, Verdict::kRestarts);
    EXPECT_FALSE(j.rebooted) << gap;
    EXPECT_EQ(j.robot_us, 1000 * (gap + 20));
  }
  FrameSequence s = Running(10'000);
  FrameStamp boot = At(12'000);
  boot.timestamp_ms = 5;
  EXPECT_EQ(s.Judge(boot).verdict, Verdict::kHeld);
  boot = At(12'020);
  boot.timestamp_ms = 25;
  const auto j = s.Judge(boot);
  EXPECT_EQ(j.verdict, Verdict::kRestarts);
  EXPECT_TRUE(j.rebooted);
  EXPECT_EQ(s.reboots(), 1);
}

TEST(FrameSequence, SameTimeAgainIsNothingNew) {
  FrameSequence s = Running(10'000);
  EXPECT_EQ(s.Judge(At(10'000)).verdict, Verdict::kDuplicate);
  EXPECT_EQ(s.Judge(At(10'020)).robot_us, 20'000);
}

TEST(Odometry, TurnsAndWrapsAreExact) {
  const WheelCalibration wheel{.ticks_per_metre = 10'000, .track_width_m = 0.25};
  const PlanarMotion straight = MotionBetween({65'000, 100}, {464, 1'100}, wheel);
  EXPECT_NEAR(straight.dx_m, 0.1, 1e-12);
  EXPECT_NEAR(straight.dy_m, 0, 1e-12);
  const PlanarMotion back = MotionBetween({464, 1'100}, {65'000, 100}, wheel);
  EXPECT_NEAR(back.dx_m, -0.1, 1e-12);
  // The base makes a quarter turn to the left around the left wheel.
  const auto arc = static_cast<uint16_t>(std::lround(10'000 * 0.25 * std::numbers::pi / 2));
  const PlanarMotion quarter = MotionBetween({0, 0}, {0, arc}, wheel);
  EXPECT_NEAR(quarter.dyaw_rad, std::numbers::pi / 2, 1e-4);
  EXPECT_NEAR(quarter.dx_m, 0.125, 1e-4);
  EXPECT_NEAR(quarter.dy_m, 0.125, 1e-4);
}

TEST(Odometry, HeadingWrapsByWholeTurns) {
  EXPECT_NEAR(HeadingFromCentidegrees(9000), std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(HeadingFromCentidegrees(-9000), -std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(HeadingFromCentidegrees(27000), -std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(HeadingFromCentidegrees(-32768), 3232 * std::numbers::pi / 18000, 1e-12);
  for (int a = -32768; a <= 32767; ++a) {
    EXPECT_LE(std::abs(HeadingFromCentidegrees(static_cast<int16_t>(a))), std::numbers::pi);
  }
}

}  // namespace
}  // namespace gw::kobuki

// How late the wheels' stamps are is found from the turns, however the base resamples and jitters.
#include "dr_ekf/core/time_offset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/core/random.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

// rad/s: a turn of 90 degrees to either side every ten seconds, within 3 s.
double RateAt(double t) {
  const double phase = std::fmod(t, 10.0);
  if (phase > 3) return 0;
  const double sign = std::fmod(t, 20.0) < 10 ? 1 : -1;
  return sign * M_PI / 6 * (1 - std::cos(2 * M_PI * phase / 3));
}

struct Base {
  double track = 1;  // measured over true turn
  bool resampled = false;
  double jitter_s = 0;  // sigma of the stamps
};

// Two minutes of a gyro at 100 Hz and a base whose stamps are late by `late_s`.
TimeOffset Drive(double late_s, const Base& base) {
  TimeOffset out;
  CounterRng rng(3, 0, 0);
  double turn = 0, sent = 0, counted = 0;
  Utime before{0};
  for (int ms = 1; ms <= 120'000; ++ms) {
    const double t = ms * 1e-3;
    turn += RateAt(t) * 1e-3;
    if (ms % 10 == 0) out.AddGyro(Utime{ms * 1000}, RateAt(t) + 0.01 + 0.004 * rng.Normal());
    if (!base.resampled || ms % 20 == 0) counted = turn;
    if (ms % 50 != 0) continue;
    const Utime stamp{static_cast<int64_t>(1e6 * (t + late_s + base.jitter_s * rng.Normal()))};
    out.AddWheels(before, stamp, base.track * (counted - sent));
    sent = counted;
    before = stamp;
  }
  return out;
}

TEST(TimeOffset, IsFoundToThreeMilliseconds) {
  for (const double late : {-0.08, 0.0, 0.047, 0.15}) {
    for (const double track : {0.5, 1.0, 2.0}) {
      const TimeOffset offset = Drive(late, {.track = track});
      EXPECT_NEAR(offset.offset_s(), late, 0.003) << track;
      EXPECT_LT(offset.sigma_s(), 0.002);
    }
  }
}

TEST(TimeOffset, OfResampledOdometryHasTheMeanAgeOfItsReadingsInIt) {
  // Readings are 0 or 10 ms old when they are sent.
  for (const double late : {0.047, 0.15}) {
    const TimeOffset offset = Drive(late, {.resampled = true, .jitter_s = 0.005});
    EXPECT_NEAR(offset.offset_s(), late + 0.005, 0.005);
    EXPECT_LT(std::abs(offset.offset_s() - late - 0.005), 3 * offset.sigma_s());
  }
}

TEST(TimeOffset, WithoutATurnNothingIsKnown) {
  TimeOffset offset;
  CounterRng rng(4, 0, 0);
  for (int i = 1; i <= 3000; ++i) {
    offset.AddGyro(Utime{i * 10'000}, 0.01 + 0.004 * rng.Normal());
    if (i % 5 == 0) offset.AddWheels(Utime{(i - 5) * 10'000}, Utime{i * 10'000}, 0);
  }
  EXPECT_LT(std::abs(offset.offset_s()), 0.5 * TimeOffset::kPrior);
  EXPECT_GT(offset.sigma_s(), 0.5 * TimeOffset::kPrior);
}

// The simulated robot, its wheels' stamps late by this.
std::pair<DrFilter, std::vector<DrState>> DriveLate(const Recording& r, double late_s) {
  std::vector<Sample> samples = r.samples;
  for (Sample& sample : samples) {
    if (auto* wheel = std::get_if<WheelSample>(&sample)) {
      wheel->utime = wheel->utime + DurationFromSeconds(late_s);
      wheel->utime_begin = wheel->utime_begin + DurationFromSeconds(late_s);
    }
  }
  DrFilter filter = std::move(DrFilter::Create({}, r.calibration)).value();
  std::vector<DrState> states = FeedAll(filter, samples);
  return {std::move(filter), std::move(states)};
}

TEST(TimeOffset, IsTakenOutOfTheStampsOfTheFilter) {
  const Recording r = Simulate(WheelsAndImu(), {}, {.seed = 8, .duration_s = 60});
  // Over the second half, when the offset is known.
  const auto error_of = [&r](const std::vector<DrState>& states, int* slips) {
    const auto at = std::find_if(states.begin(), states.end(), [&](const DrState& s) {
      return (s.utime - r.begin).seconds() > 30;
    });
    *slips =
        static_cast<int>(std::count_if(at, states.end(), [](const auto& s) { return s.slip; }));
    const SE3 motion = at->T_OB.inverse() * states.back().T_OB;
    const SE3 truth = r.TruthAt(at->utime).inverse() * r.TruthAt(states.back().utime);
    return (motion.inverse() * truth).translation().norm();
  };
  int slips = 0;
  const double undisturbed = error_of(DriveLate(r, 0).second, &slips);
  for (const double late : {0.047, 0.15}) {
    const auto [filter, states] = DriveLate(r, late);
    EXPECT_NEAR(filter.wheel_time_offset().offset_s(), late, 0.003);
    const double error = error_of(states, &slips);
    std::printf("late by %.3f s: found %.4f s, error %.3f m (in time: %.3f m)\n", late,
                filter.wheel_time_offset().offset_s(), error, undisturbed);
    EXPECT_EQ(slips, 0);
    EXPECT_LT(error, undisturbed + 0.1);
  }
}

}  // namespace
}  // namespace gw::dr_ekf

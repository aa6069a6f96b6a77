#include "dr_ekf/core/dr_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "common/core/random.h"
#include "common/good_weights/dr_history.h"
#include "dr_ekf/test/filter_testing.h"

namespace gw::dr_ekf {
namespace {

template <typename... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;  // clang 14 does not deduce aggregates

// With an IMU the first wheel interval begins before the first sample and is refused.
int LateAtStart(const Recording& r) {
  return r.calibration.imu.present ? 1 : 0;
}

TEST(DrFilter, RefusesACalibrationWithoutInputs) {
  const Result<DrFilter> filter = DrFilter::Create({}, {});
  ASSERT_FALSE(filter.ok());
  EXPECT_EQ(filter.error().code, ErrorCode::kBadConfig);
}

struct Mode {
  const char* name;
  Calibration (*calibration)();
  double max_yaw;  // rad, after 30 s
};
void PrintTo(const Mode& mode, std::ostream* os) {
  *os << mode.name;
}

class DrFilterModes : public testing::TestWithParam<Mode> {};
INSTANTIATE_TEST_SUITE_P(Modes, DrFilterModes,
                         testing::Values(Mode{"wheels", WheelsOnly, 0.6},
                                         Mode{"gyro", WheelsAndGyro, 0.06},
                                         Mode{"imu", WheelsAndImu, 0.06}),
                         [](const auto& test) { return test.param.name; });

TEST_P(DrFilterModes, FollowsTheRobot) {
  SimOptions options;
  options.gyro_bias = {0.01, -0.005, 0.008};
  const Recording r = Simulate(GetParam().calibration(), {}, options);
  DrFilter filter = Make(r.calibration);
  const std::vector<DrState> states = FeedAll(filter, r.samples);
  ASSERT_GT(states.size(), 1000u);
  const DrState& last = states.back();
  const SE3 error = TruthFromStart(r, last.utime).inverse() * last.T_OB;
  EXPECT_LT(error.translation().norm(), 0.5);
  EXPECT_LT(error.Log().tail<3>().norm(), GetParam().max_yaw);
  std::printf("%s: %.3f m, %.4f rad, sigma %.3f m %.4f rad\n", GetParam().name,
              error.translation().norm(), error.Log().tail<3>().norm(),
              std::sqrt(last.cov_T_OB(0, 0)), std::sqrt(last.cov_T_OB(5, 5)));
}

TEST_P(DrFilterModes, SameInputGivesTheSameBytes) {
  const Recording r = Simulate(GetParam().calibration(), {}, {.duration_s = 5});
  DrFilter a = Make(r.calibration), b = Make(r.calibration);
  const std::vector<DrState> from_a = FeedAll(a, r.samples), from_b = FeedAll(b, r.samples);
  ASSERT_EQ(from_a.size(), from_b.size());
  for (size_t i = 0; i < from_a.size(); ++i) ExpectIdentical(from_a[i], from_b[i]);
}

// 60 s parked, with noise and bias: position and heading are the ones of the moment it was seen to
// stand, bit by bit.
TEST_P(DrFilterModes, PoseDoesNotWalkWhileParked) {
  SimOptions options{.duration_s = 60, .parked_s = 60};
  options.gyro_bias = {0.01, -0.015, 0.02};
  options.accel_bias = {0.05, -0.03, 0.1};
  const Recording r = Simulate(GetParam().calibration(), {}, options);
  DrFilter filter = Make(r.calibration);
  const DrState* held = nullptr;
  const std::vector<DrState> states = FeedAll(filter, r.samples);
  for (const DrState& s : states) {
    if (s.utime - r.begin < Milliseconds(1000)) continue;
    ASSERT_TRUE(s.stationary) << (s.utime - r.begin).seconds();
    if (held == nullptr) held = &s;
    ASSERT_EQ(s.T_OB.translation(), held->T_OB.translation());
    ASSERT_EQ(s.T_OB.rotation().coeffs(), held->T_OB.rotation().coeffs());
    ASSERT_TRUE(s.v_OB_B.isZero());
  }
  const SE3 error = TruthFromStart(r, states.back().utime).inverse() * states.back().T_OB;
  EXPECT_LT(error.translation().norm(), 2e-3);
  EXPECT_LT(std::abs(error.Log()[5]), 2e-3);
}

// Every fifth wheel sample late by 60 to 200 ms, and pairs of IMU samples swapped: the state after
// the last sample is bit by bit that of the right order.
TEST_P(DrFilterModes, LateSamplesGiveTheResultOfTheRightOrder) {
  const Recording r = Simulate(GetParam().calibration(), {}, {.duration_s = 10});
  std::vector<std::pair<Utime, Sample>> arrivals;
  CounterRng rng(5, 0, 0);
  int index = 0;
  for (const Sample& sample : r.samples) {
    Utime arrival = std::visit([](const auto& s) { return s.utime; }, sample);
    const bool last = (r.begin + Milliseconds(9800)) < arrival;
    const bool first = arrival < r.begin + Milliseconds(200);
    if (!last && !first && ++index % 5 == 0) arrival = arrival + Milliseconds(60 + rng.Below(140));
    arrivals.emplace_back(arrival, sample);
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  DrFilter ordered = Make(r.calibration), shuffled = Make(r.calibration);
  const std::vector<DrState> expected = FeedAll(ordered, r.samples);
  std::vector<DrState> states;
  DrCounters counters;
  for (const auto& [arrival, sample] : arrivals) {
    DrFilter::Output out = Feed(shuffled, sample);
    counters = out.counters;
    states.insert(states.end(), out.states.begin(), out.states.end());
  }
  EXPECT_GT(counters.reordered, 50);
  EXPECT_EQ(counters.rejected_late, LateAtStart(r));
  EXPECT_EQ(counters.rejected_non_monotonic, 0);
  ExpectIdentical(states.back(), expected.back());
  for (size_t i = 1; i < states.size(); ++i) ASSERT_LT(states[i - 1].utime, states[i].utime);
}

TEST_P(DrFilterModes, OlderThanTheHistoryIsRejectedAndCounted) {
  const Recording r = Simulate(GetParam().calibration(), {}, {.duration_s = 4});
  DrFilter filter = Make(r.calibration);
  const std::vector<DrState> states = FeedAll(filter, r.samples);
  for (size_t i = 0; i < 20; ++i) {
    const DrFilter::Output out = Feed(filter, r.samples[i]);
    EXPECT_EQ(out.counters.rejected_late, static_cast<int64_t>(i + 1 + LateAtStart(r)));
    EXPECT_TRUE(out.states.empty());
  }
}

// What the published noise composes to, against the exact covariance of the filter, while driving.
// Sigma per axis of the body's plane: never more than 1.5 times (over 0.04 s: twice, errors that
// come and go within a few samples are no growth) too small, nor twice too large. Intervals begin
// and end with a wheel sample: between them the filter extrapolates, which is such an error.
TEST_P(DrFilterModes, PublishedGrowthAgreesWithTheExactCovariance) {
  DrEkfConfig config;
  config.history_ms = 30000;
  const Recording r =
      Simulate(GetParam().calibration(), config, {.duration_s = 25, .stops = false});
  DrFilter filter = Make(r.calibration, config);
  DrHistory history;
  for (const DrState& s : FeedAll(filter, r.samples)) history.Push(s);
  for (const double length : {0.04, 1.0, 10.0}) {
    double smallest = 1e9, largest = 0;
    for (int i = 0; i < 20; ++i) {
      const Utime a = r.begin + Milliseconds(6000 + 400 * i);  // wheels: every 20 ms
      const Utime b = a + DurationFromSeconds(length);
      const Result<DrIncrement> exact = filter.Increment(a, b);
      const auto composed = history.Increment(a, b);
      ASSERT_TRUE(exact.ok() && composed);
      EXPECT_LT((exact->T_BaBb.inverse() * composed->T_BaBb).Log().norm(), 0.02);
      for (const int axis : {0, 1, 5}) {
        const double ratio = std::sqrt(composed->cov(axis, axis) / exact->cov(axis, axis));
        smallest = std::min(smallest, ratio);
        largest = std::max(largest, ratio);
      }
    }
    std::printf("%s, %5.2f s: published sigma / exact sigma %.2f .. %.2f\n", GetParam().name,
                length, smallest, largest);
    EXPECT_GT(smallest, length < 0.1 ? 0.5 : 1 / 1.5) << length;
    EXPECT_LT(largest, 2) << length;
  }
}

TEST_P(DrFilterModes, HostileInputIsCountedAndHarmless) {
  const Recording r = Simulate(GetParam().calibration(), {}, {.seed = 3, .duration_s = 20});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CounterRng rng(9, 0, 0);
  DrFilter filter = Make(r.calibration);
  DrCounters counters;
  size_t published = 0, fed = 0;
  Utime before = {0};
  uint32_t reset_counter = 0;
  for (const Sample& clean : r.samples) {
    std::vector<Sample> pushed = {clean};
    Sample bad = clean;
    switch (rng.Below(12)) {
      case 0:  // not a number
        std::visit(Overloaded{[&](ImuSample& s) { s.w_I_rad_s.y() = nan; },
                              [&](WheelSample& s) { s.dx_m = nan; }},
                   bad);
        pushed.push_back(bad);
        break;
      case 1:  // twice
        pushed.push_back(clean);
        break;
      case 2:  // far ahead
        std::visit(Overloaded{[&](ImuSample& s) { s.utime.us += 3'600'000'000; },
                              [&](WheelSample& s) {
                                s.utime.us += 3'600'000'000;
                                s.utime_begin.us += 3'600'000'000;
                              }},
                   bad);
        pushed.push_back(bad);
        break;
      case 3:  // absurd
        std::visit(Overloaded{[&](ImuSample& s) { s.w_I_rad_s.x() = 1e9; },
                              [&](WheelSample& s) { s.dx_m = 5; }},
                   bad);
        pushed.push_back(bad);
        break;
      case 4:  // extreme times
        std::visit([&](auto& s) { s.utime.us = std::numeric_limits<int64_t>::max(); }, bad);
        pushed.push_back(bad);
        std::visit([&](auto& s) { s.utime.us = std::numeric_limits<int64_t>::min(); }, bad);
        pushed.push_back(bad);
        break;
      case 5:  // from long ago
        std::visit(Overloaded{[&](ImuSample& s) { s.utime.us -= 60'000'000; },
                              [&](WheelSample& s) {
                                s.utime.us -= 60'000'000;
                                s.utime_begin.us -= 60'000'000;
                              }},
                   bad);
        pushed.push_back(bad);
        break;
      case 6:  // lost
        pushed.clear();
        break;
      default:
        break;
    }
    for (const Sample& sample : pushed) {
      const DrFilter::Output out = Feed(filter, sample);
      ++fed;
      counters = out.counters;
      for (const DrState& s : out.states) {
        ++published;
        EXPECT_TRUE(s.T_OB.IsFinite() && s.cov_T_OB.allFinite());
        EXPECT_TRUE(s.utime > before || s.reset_counter != reset_counter);
        before = s.utime;
        reset_counter = s.reset_counter;
      }
    }
  }
  EXPECT_GT(counters.rejected_invalid, 20);
  EXPECT_GT(counters.rejected_non_monotonic, 20);
  EXPECT_GT(counters.rejected_future, 20);
  EXPECT_GT(counters.rejected_absurd, 20);
  EXPECT_GT(counters.rejected_late, 20);
  EXPECT_EQ(counters.imu_used + counters.wheel_used + counters.rejected_invalid +
                counters.rejected_non_monotonic + counters.rejected_future +
                counters.rejected_absurd + counters.rejected_late,
            static_cast<int64_t>(fed));
  EXPECT_EQ(counters.resets, 0);
  EXPECT_GT(published, r.samples.size() / 3);
}

TEST_P(DrFilterModes, AGapInEverythingMovesTheResetCounter) {
  const Recording r = Simulate(GetParam().calibration(), {}, {.duration_s = 12});
  DrFilter filter = Make(r.calibration);
  std::vector<DrState> states;
  for (const Sample& sample : r.samples) {
    const double t =
        (std::visit([](const auto& s) { return s.utime; }, sample) - r.begin).seconds();
    if (t > 5 && t < 8) continue;
    for (const DrState& s : Feed(filter, sample).states) states.push_back(s);
  }
  EXPECT_EQ(states.front().reset_counter, 0u);
  EXPECT_EQ(states.back().reset_counter, 1u);
  EXPECT_GT((states.back().utime - r.begin).seconds(), 11.9);
  EXPECT_GT(states.back().cov_T_OB(0, 0), 1.0);
  EXPECT_FALSE(filter.Increment(r.begin + Milliseconds(4500), r.begin + Milliseconds(9000)).ok());
}

TEST_P(DrFilterModes, GoesOnAfterTheClockWasSetBack) {
  const Recording r = Simulate(GetParam().calibration(), {}, {.duration_s = 6});
  DrFilter filter = Make(r.calibration);
  for (const Sample& sample : r.samples) {
    Sample later = sample;
    std::visit(Overloaded{[](ImuSample& s) { s.utime.us += 100'000'000; },
                          [](WheelSample& s) {
                            s.utime.us += 100'000'000;
                            s.utime_begin.us += 100'000'000;
                          }},
               later);
    Feed(filter, later);
  }
  const std::vector<DrState> states = FeedAll(filter, r.samples);
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states.front().reset_counter, 1u);
  EXPECT_EQ(states.back().reset_counter, 1u);
  EXPECT_GT((states.back().utime - r.begin).seconds(), 5.9);
}

}  // namespace
}  // namespace gw::dr_ekf

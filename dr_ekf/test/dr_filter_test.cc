#include "dr_ekf/core/dr_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "common/core/random.h"
#include "common/good_weights/dr_history.h"
#include "dr_ekf/core/noise_model.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

DrFilter Make(const Calibration& calibration, const DrEkfConfig& config = {}) {
  Result<DrFilter> filter = DrFilter::Create(config, calibration);
  EXPECT_TRUE(filter.ok());
  return std::move(filter).value();
}

SE3 TruthFromStart(const Recording& r, Utime t) {
  return r.T_GB.front().inverse() * r.TruthAt(t);
}

template <typename... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;  // clang 14 does not deduce aggregates

// Bit by bit, but for the count of publications.
void ExpectIdentical(const DrState& a, const DrState& b) {
  EXPECT_EQ(a.utime, b.utime);
  EXPECT_EQ(a.T_OB.translation(), b.T_OB.translation());
  EXPECT_EQ(a.T_OB.rotation().coeffs(), b.T_OB.rotation().coeffs());
  EXPECT_EQ(a.v_OB_B, b.v_OB_B);
  EXPECT_EQ(a.w_OB_B, b.w_OB_B);
  EXPECT_EQ(a.gyro_bias_rad_s, b.gyro_bias_rad_s);
  EXPECT_EQ(a.accel_bias_m_s2, b.accel_bias_m_s2);
  EXPECT_EQ(a.wheel_scale, b.wheel_scale);
  EXPECT_EQ(a.cov_T_OB, b.cov_T_OB);
  EXPECT_EQ(a.cov_twist_white, b.cov_twist_white);
  EXPECT_EQ(a.cov_twist_coherent, b.cov_twist_coherent);
  EXPECT_EQ(a.way_scale_sigma, b.way_scale_sigma);
  EXPECT_EQ(a.turn_scale_sigma, b.turn_scale_sigma);
}

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
      const auto composed = history.Increment(a, b, {0});
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

// ---- One sensor fails -------------------------------------------------------------------------

struct LongestGap {
  Utime last = {0};
  DurationUs longest = {0};
  void Add(Utime t) {
    if (last.us != 0) longest = std::max(longest, t - last);
    last = t;
  }
};

TEST(DrFilterDropout, WithoutGyroTheWheelsCarryOn) {
  for (const auto calibration : {WheelsAndGyro, WheelsAndImu}) {
    const Recording r = Simulate(calibration(), {}, {.duration_s = 20});
    DrFilter filter = Make(r.calibration);
    LongestGap gap;
    DrState last;
    for (const Sample& sample : r.samples) {
      const auto* imu = std::get_if<ImuSample>(&sample);
      const double t = imu != nullptr ? (imu->utime - r.begin).seconds() : 0;
      if (imu != nullptr && t > 8 && t < 15) continue;
      for (const DrState& s : Feed(filter, sample).states) {
        const double at = (s.utime - r.begin).seconds();
        if (at > 8.3 && at < 15) {
          EXPECT_FALSE(s.imu_alive);
        }
        gap.Add(s.utime);
        last = s;
      }
    }
    EXPECT_LE(gap.longest, Milliseconds(40));  // two wheel periods
    EXPECT_TRUE(last.imu_alive);
    EXPECT_EQ(last.reset_counter, 0u);
    const Vector6d error = (last.T_OB.inverse() * TruthFromStart(r, last.utime)).Log();
    for (const int axis : {0, 1, 5}) {
      EXPECT_LT(std::abs(error[axis]), 4 * std::sqrt(last.cov_T_OB(axis, axis))) << axis;
    }
    EXPECT_LT(error.head<2>().norm(), 0.6);
  }
}

TEST(DrFilterDropout, WithoutWheelsTheCovarianceGrowsHonestly) {
  for (const auto calibration : {WheelsAndGyro, WheelsAndImu}) {
    int outside = 0;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      const Recording r = Simulate(calibration(), {}, {.seed = seed, .duration_s = 20});
      DrFilter filter = Make(r.calibration);
      LongestGap gap;
      DrState at_loss, at_end;
      for (const Sample& sample : r.samples) {
        const auto* wheel = std::get_if<WheelSample>(&sample);
        if (wheel != nullptr && wheel->utime - r.begin > Milliseconds(12000)) continue;
        for (const DrState& s : Feed(filter, sample).states) {
          gap.Add(s.utime);
          if (s.utime - r.begin < Milliseconds(12000)) at_loss = s;
          at_end = s;
        }
      }
      EXPECT_LE(gap.longest, Milliseconds(20));
      EXPECT_FALSE(at_end.wheels_alive);
      const auto spread = [](const DrState& s) { return s.cov_T_OB(0, 0) + s.cov_T_OB(1, 1); };
      EXPECT_GT(spread(at_end), 1.5 * spread(at_loss)) << r.calibration.imu.has_accel << seed;
      const Vector6d error = (at_end.T_OB.inverse() * TruthFromStart(r, at_end.utime)).Log();
      for (const int axis : {0, 1, 5}) {
        outside += std::abs(error[axis]) > 2.5 * std::sqrt(at_end.cov_T_OB(axis, axis));
      }
    }
    EXPECT_LE(outside, 4);  // of 60; 1.2 % are expected
  }
}

TEST(DrFilterDropout, WheelsInTheAirAreNotBelieved) {
  const Recording r = Simulate(WheelsAndGyro(), {}, {.duration_s = 6, .drive = false});
  DrFilter filter = Make(r.calibration);
  DrState last;
  int64_t drops = 0;
  for (Sample sample : r.samples) {
    if (auto* wheel = std::get_if<WheelSample>(&sample); wheel != nullptr) {
      if (wheel->utime - r.begin > Milliseconds(3000)) {
        wheel->contact.wheel_drop = true;
        wheel->dx_m = 0.01;
      }
    }
    const DrFilter::Output out = Feed(filter, sample);
    drops = out.counters.step.wheel_drops;
    if (!out.states.empty()) last = out.states.back();
  }
  EXPECT_GT(drops, 100);
  EXPECT_TRUE(last.slip);
  EXPECT_LT(last.T_OB.translation().norm(), 0.05);
}

// ---- What is observable -----------------------------------------------------------------------

TEST(DrFilterObservability, GyroBiasIsFoundAtRestAndByDriving) {
  for (const double parked : {2.0, 0.0}) {
    SimOptions options{.duration_s = 60, .parked_s = parked};
    options.stops = parked > 0;
    options.gyro_bias = {0.01, -0.02, 0.03};
    const Recording r = Simulate(WheelsAndGyro(), {}, options);
    DrFilter filter = Make(r.calibration);
    const DrState last = FeedAll(filter, r.samples).back();
    // Only the component about z acts on a flat floor; I is turned about z here.
    const double limit = parked > 0 ? 5e-4 : 4e-3;
    EXPECT_NEAR(last.gyro_bias_rad_s.z(), 0.03, limit);
  }
}

TEST(DrFilterObservability, AGyroBiasThatJumpsWhileDrivingIsFoundAgain) {
  for (const double step : {0.02, -0.05, 0.1}) {
    SimOptions options{.seed = 4, .duration_s = 60, .gyro_step_at_s = 20, .gyro_step = step};
    const Recording r = Simulate(WheelsAndGyro(), {}, options);
    DrFilter filter = Make(r.calibration);
    const std::vector<DrState> states = FeedAll(filter, r.samples);
    EXPECT_NEAR(states.back().gyro_bias_rad_s.z(), step, 0.005) << step;
    EXPECT_FALSE(states.back().slip);
  }
}

// With an accelerometer a wrong wheel scale shows in every start, stop and curve (speed against
// acceleration). Without one nothing but the wheels knows the way: the scale stays at its prior,
// and its doubt stays in the covariance.
TEST(DrFilterObservability, WheelScaleIsFoundOnlyWithAnAccelerometer) {
  DrEkfConfig config;
  SimOptions options{.duration_s = 120, .true_scale = 1.02};
  const Recording imu = Simulate(WheelsAndImu(), config, options);
  DrFilter with_accel = Make(imu.calibration, config);
  const DrState found = FeedAll(with_accel, imu.samples).back();
  std::printf("wheel scale after 120 s: %.4f +- %.4f, true 1.02\n", found.wheel_scale,
              found.way_scale_sigma);
  EXPECT_NEAR(found.wheel_scale, 1.02, 0.01);

  const Recording gyro = Simulate(WheelsAndGyro(), config, options);
  DrFilter without_accel = Make(gyro.calibration, config);
  const DrState prior = FeedAll(without_accel, gyro.samples).back();
  EXPECT_NEAR(prior.wheel_scale, 1.0, 1e-3);
  EXPECT_GE(prior.way_scale_sigma, 0.95 * DrEkfConfig().wheel_scale_sigma);
}

// ---- Slip -------------------------------------------------------------------------------------

TEST(DrFilterSlip, WheelsThatTurnAgainstTheGyroAreFlaggedAndDoNotTurnThePose) {
  SimOptions options{.seed = 2, .duration_s = 20};
  options.slips = {{8, 9, 0.0, 1.0}};
  const Recording r = Simulate(WheelsAndGyro(), {}, options);
  DrFilter filter = Make(r.calibration);
  int flagged = 0, during = 0, after = 0;
  DrState last;
  for (const DrState& s : FeedAll(filter, r.samples)) {
    const double t = (s.utime - r.begin).seconds();
    if (t > 8.1 && t < 9) {
      ++during;
      flagged += s.slip;
      if (s.slip) {
        EXPECT_GT(
            s.cov_twist_white(0, 0),
            20 * std::pow(DrEkfConfig().wheel_sigma_m_per_sqrt_m, 2) * std::abs(s.v_OB_B.x()));
      }
    }
    if (t > 10 && t < 11) after += s.slip;
    last = s;
  }
  EXPECT_GE(flagged, 0.9 * during);
  EXPECT_EQ(after, 0);
  const Vector6d error = (last.T_OB.inverse() * TruthFromStart(r, last.utime)).Log();
  EXPECT_LT(std::abs(error[5]), 0.02);  // the wheels turned a full radian too far
}

TEST(DrFilterSlip, SpinningForwardIsRefusedWithAnAccelerometer) {
  SimOptions options{.seed = 2, .duration_s = 20};
  options.slips = {{8, 8.8, 0.6, 0.0}};
  const Recording r = Simulate(WheelsAndImu(), {}, options);
  DrFilter filter = Make(r.calibration);
  const std::vector<DrState> states = FeedAll(filter, r.samples);
  const DrState& last = states.back();
  const Vector6d error = (last.T_OB.inverse() * TruthFromStart(r, last.utime)).Log();
  EXPECT_LT(error.head<2>().norm(), 0.2);  // the wheels turned 0.48 m too far
  EXPECT_FALSE(last.slip);
}

TEST(DrFilterSlip, CleanDrivingRaisesNoAlarm) {
  for (const auto calibration : {WheelsOnly, WheelsAndGyro, WheelsAndImu}) {
    const Recording r = Simulate(calibration(), {}, {.seed = 8, .duration_s = 60});
    DrFilter filter = Make(r.calibration);
    int slips = 0;
    const std::vector<DrState> states = FeedAll(filter, r.samples);
    for (const DrState& s : states) slips += s.slip;
    EXPECT_LT(slips, 0.02 * static_cast<double>(states.size()));
  }
}

// ---- Details of the inputs --------------------------------------------------------------------

TEST(DrFilterInput, TheBaseHeadingReplacesAGyro) {
  double with = 0, without = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    for (const bool heading : {false, true}) {
      const Recording r =
          Simulate(WheelsOnly(), {}, {.seed = seed, .duration_s = 30, .with_heading = heading});
      DrFilter filter = Make(r.calibration);
      const DrState last = FeedAll(filter, r.samples).back();
      const double error = std::abs((last.T_OB.inverse() * TruthFromStart(r, last.utime)).Log()[5]);
      (heading ? with : without) += error / 10;
      EXPECT_LT(error, 4 * std::sqrt(last.cov_T_OB(5, 5)));
    }
  }
  EXPECT_LT(with, 0.3 * without);
}

// The same robot, its clocks off by what the calibration says: the same result.
TEST(DrFilterInput, TimeOffsetsOfTheCalibrationAreTakenOut) {
  Calibration shifted = WheelsAndImu();
  shifted.wheel.time_offset_s = 0.0475;
  shifted.imu.time_offset_s = -0.01;
  const Recording a = Simulate(WheelsAndImu(), {}, {.duration_s = 8});
  const Recording b = Simulate(shifted, {}, {.duration_s = 8});
  DrFilter filter_a = Make(a.calibration), filter_b = Make(b.calibration);
  ExpectIdentical(FeedAll(filter_a, a.samples).back(), FeedAll(filter_b, b.samples).back());
}

// Wheel samples that come 50 ms after they were measured cost nothing but the extrapolation.
TEST(DrFilterInput, DelayedWheelsEndInTheSamePose) {
  const Recording on_time = Simulate(WheelsAndImu(), {}, {.duration_s = 10});
  const Recording delayed = Simulate(WheelsAndImu(), {}, {.duration_s = 10, .wheel_delay_s = 0.05});
  DrFilter a = Make(on_time.calibration), b = Make(delayed.calibration);
  const std::vector<DrState> sa = FeedAll(a, on_time.samples), sb = FeedAll(b, delayed.samples);
  const Utime t = on_time.begin + Milliseconds(9900);
  const Result<DrIncrement> ia = a.Increment(t - Milliseconds(500), t);
  const Result<DrIncrement> ib = b.Increment(t - Milliseconds(500), t);
  ASSERT_TRUE(ia.ok() && ib.ok());
  EXPECT_EQ(ia->T_BaBb.translation(), ib->T_BaBb.translation());
  EXPECT_EQ(ia->cov, ib->cov);
}

// A shock within one IMU sample, 80 m/s^2, is a change of speed by 0.4 m/s wherever the stamp of a
// wheel sample lies between the IMU's.
TEST(DrFilterInput, AShockIsWholeWhereAWheelSampleDividesIt) {
  constexpr int kShock = 400;  // of the IMU's samples, one every 5 ms
  const Calibration calibration = WheelsAndImu();
  for (const int divided_ms : {0, 1, 2, 3, 4}) {
    DrFilter filter = Make(calibration);
    Utime wheels;
    DrState last;
    for (int i = 0; i <= kShock + 1; ++i) {
      const Utime utime{5000 * i};
      if (i % 10 == 0 && i > 0) {
        WheelSample sample;
        sample.utime_begin = wheels;
        sample.utime = wheels = utime - Milliseconds(5 - divided_ms);
        sample.dx_m = 0.3 * (sample.utime - sample.utime_begin).seconds();
        filter.Push(sample);
      }
      ImuSample imu;
      imu.utime = utime;
      imu.has_accel = true;
      imu.w_I_rad_s.setConstant(i % 2 == 0 ? 1e-4 : -1e-4);  // one that stands is not believed
      imu.a_I_m_s2 = calibration.imu.T_BI.rotation().conjugate() *
                     Eigen::Vector3d(i == kShock ? 80.0 : 0.0, 0, kGravity);
      for (const DrState& state : filter.Push(imu).states) last = state;
    }
    EXPECT_NEAR(last.v_OB_B.x(), 0.3 + 0.4, 0.01) << divided_ms;
  }
}

TEST(DrFilterInput, RollAndPitchComeFromGravity) {
  Calibration calibration = WheelsAndImu();
  SimOptions options{.duration_s = 10, .parked_s = 2, .floor_tilt = 0.03};
  const Recording r = Simulate(calibration, {}, options);
  DrFilter filter = Make(r.calibration);
  const DrState last = FeedAll(filter, r.samples).back();
  EXPECT_TRUE(last.gravity_aligned);
  const Eigen::Vector3d up = last.T_OB.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d truth =
      r.TruthAt(last.utime).rotation().conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((up - truth).norm(), 0.005);
}

}  // namespace
}  // namespace gw::dr_ekf

// The wheels' sum is a fact: whatever is wrong with the stamps of the samples, the way that the
// wheels drove is the way of the filter, and no stamp makes slip.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "common/core/random.h"
#include "dr_ekf/core/wheel_chain.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

// Offsets of stamps in periods, at most a half, mean zero in the long run.
enum class Jitter { kEven, kAlternating, kSawtooth, kBursts };

struct Case {
  const char* name;
  Jitter jitter;
  double rate_hz;
  Calibration (*calibration)();
};
void PrintTo(const Case& c, std::ostream* os) {
  *os << c.name << " " << c.rate_hz;
}

double OffsetOf(Jitter jitter, int64_t k, CounterRng& rng) {
  switch (jitter) {
    case Jitter::kEven:
      return rng.Uniform(-0.5, 0.5);
    case Jitter::kAlternating:
      return k % 2 == 0 ? 0.5 : -0.5;
    case Jitter::kSawtooth:  // sampled at another rate than it is stamped
      return static_cast<double>(k % 7) / 6.0 - 0.5;
    case Jitter::kBursts:  // three samples come together
      return 0.5 * (1 - static_cast<double>(k % 3));
  }
  return 0;
}

// The wheels' stamps of a recording moved; each interval begins where the one before ends.
std::vector<Sample> Jittered(const Recording& r, Jitter jitter) {
  CounterRng rng(17, 0, 0);
  std::vector<Sample> out;
  std::optional<Utime> end;
  int64_t k = 0;
  for (Sample sample : r.samples) {
    if (auto* wheel = std::get_if<WheelSample>(&sample)) {
      const double period = 1 / r.calibration.wheel.rate_hz;
      wheel->utime = wheel->utime + DurationFromSeconds(period * OffsetOf(jitter, k++, rng));
      if (end) wheel->utime_begin = *end;
      end = wheel->utime;
    }
    out.push_back(sample);
  }
  return out;
}

double WheelWay(const std::vector<Sample>& samples) {
  double way = 0;
  for (const Sample& sample : samples) {
    if (const auto* wheel = std::get_if<WheelSample>(&sample)) {
      way += std::copysign(std::hypot(wheel->dx_m, wheel->dy_m), wheel->dx_m);
    }
  }
  return way;
}

double WayOfStates(const std::vector<DrState>& states) {
  double way = 0;
  for (size_t i = 1; i < states.size(); ++i) {
    const SE3 step = states[i - 1].T_OB.inverse() * states[i].T_OB;
    way += std::copysign(step.translation().norm(), step.translation().x());
  }
  return way;
}

class WheelSums : public testing::TestWithParam<Case> {};
std::vector<Case> AllCases() {
  std::vector<Case> out;
  for (const double rate : {10.0, 20.0, 50.0}) {
    for (const auto& [name, calibration] :
         {std::pair("wheels", &WheelsOnly), std::pair("gyro", &WheelsAndGyro),
          std::pair("imu", &WheelsAndImu)}) {
      for (const Jitter jitter :
           {Jitter::kEven, Jitter::kAlternating, Jitter::kSawtooth, Jitter::kBursts}) {
        out.push_back({name, jitter, rate, calibration});
      }
    }
  }
  return out;
}
std::string CaseName(const testing::TestParamInfo<Case>& test) {
  return std::string(test.param.name) + "_" + std::to_string(static_cast<int>(test.param.rate_hz)) +
         "Hz_" + std::to_string(static_cast<int>(test.param.jitter));
}
INSTANTIATE_TEST_SUITE_P(All, WheelSums, testing::ValuesIn(AllCases()), CaseName);

TEST_P(WheelSums, JitterOfStampsCostsNoWayAndIsNoSlip) {
  Calibration calibration = GetParam().calibration();
  calibration.wheel.rate_hz = GetParam().rate_hz;
  SimOptions options{.seed = 31, .duration_s = 40};
  options.wheel_noise = 0.3;
  const Recording r = Simulate(calibration, {}, options);
  const std::vector<Sample> samples = Jittered(r, GetParam().jitter);
  DrFilter filter = std::move(DrFilter::Create({}, calibration)).value();
  int slips = 0;
  std::vector<DrState> states;
  DrCounters counters;
  for (const Sample& sample : samples) {
    DrFilter::Output out = Feed(filter, sample);
    counters = out.counters;
    for (DrState& s : out.states) {
      slips += s.slip;
      states.push_back(std::move(s));
    }
  }
  EXPECT_EQ(slips, 0);
  EXPECT_EQ(counters.resets, 0);
  EXPECT_EQ(counters.rejected_absurd, 0);
  const double way = WheelWay(samples);
  EXPECT_GT(way, 5);
  RecordProperty("way_ratio", std::to_string(WayOfStates(states) / way));
  EXPECT_NEAR(WayOfStates(states), way, 0.01 * way);
}

WheelSample At(int64_t begin_ms, int64_t end_ms, double dx) {
  WheelSample s;
  s.utime_begin = {begin_ms * 1000};
  s.utime = {end_ms * 1000};
  s.dx_m = dx;
  return s;
}

TEST(WheelChain, ASampleWithoutTimeJoinsTheNextOne) {
  WheelChain chain({}, Milliseconds(20));
  EXPECT_EQ(chain.Add(At(0, 20, 0.01)).fate, WheelChain::Fate::kReady);
  EXPECT_EQ(chain.Add(At(20, 20, 0.01)).fate, WheelChain::Fate::kWaits);
  const WheelChain::Link link = chain.Add(At(20, 45, 0.01));
  ASSERT_EQ(link.fate, WheelChain::Fate::kReady);
  EXPECT_EQ(link.interval.utime_begin.us, 20'000);
  EXPECT_EQ(link.interval.utime.us, 45'000);
  EXPECT_DOUBLE_EQ(link.interval.dx_m, 0.02);
}

TEST(WheelChain, AStampThatGoesBackALittleLosesNoWay) {
  WheelChain chain({}, Milliseconds(20));
  EXPECT_EQ(chain.Add(At(0, 100, 0.03)).fate, WheelChain::Fate::kReady);
  EXPECT_EQ(chain.Add(At(100, 60, 0.01)).fate, WheelChain::Fate::kWaits);
  EXPECT_EQ(chain.Add(At(60, 80, 0.01)).fate, WheelChain::Fate::kWaits);
  EXPECT_EQ(chain.Add(At(80, 100, 0.01)).fate, WheelChain::Fate::kWaits);
  const WheelChain::Link link = chain.Add(At(100, 120, 0.01));
  ASSERT_EQ(link.fate, WheelChain::Fate::kReady);
  EXPECT_EQ(link.interval.utime_begin.us, 100'000);
  EXPECT_DOUBLE_EQ(link.interval.dx_m, 0.04);
}

TEST(WheelChain, AnAbsurdSampleIsNoMotion) {
  WheelChain chain({}, Milliseconds(20));
  EXPECT_EQ(chain.Add(At(0, 20, 0.01)).fate, WheelChain::Fate::kReady);
  EXPECT_EQ(chain.Add(At(20, 40, 5.0)).fate, WheelChain::Fate::kAbsurd);
  const WheelChain::Link link = chain.Add(At(40, 60, 0.01));
  ASSERT_EQ(link.fate, WheelChain::Fate::kReady);
  EXPECT_EQ(link.interval.utime_begin.us, 40'000);
}

TEST(WheelChain, ALateSampleStandsAlone) {
  WheelChain chain({}, Milliseconds(20));
  EXPECT_EQ(chain.Add(At(0, 20, 0.01)).fate, WheelChain::Fate::kReady);
  EXPECT_EQ(chain.Add(At(40, 60, 0.01)).fate, WheelChain::Fate::kReady);
  const WheelChain::Link late = chain.Add(At(20, 40, 0.02));
  ASSERT_EQ(late.fate, WheelChain::Fate::kReady);
  EXPECT_EQ(late.interval.utime_begin.us, 20'000);
  EXPECT_DOUBLE_EQ(chain.Add(At(60, 80, 0.01)).interval.dx_m, 0.01);
}

// Seconds without a sample, then one that says what was driven.
TEST(WheelSumsAlone, ALongIntervalIsDrivenWay) {
  DrFilter filter = std::move(DrFilter::Create({}, WheelsOnly())).value();
  DrState last;
  int64_t ms = 0;
  const auto push = [&](int64_t end_ms, double dx) {
    for (DrState& s : filter.Push(At(ms, end_ms, dx)).states) last = s;
    ms = end_ms;
  };
  for (int i = 0; i < 100; ++i) push(ms + 20, 0.01);
  push(ms + 3000, 1.5);
  for (int i = 0; i < 100; ++i) push(ms + 20, 0.01);
  EXPECT_NEAR(last.T_OB.translation().x(), 3.5, 0.01);
  EXPECT_EQ(last.reset_counter, 0u);
}

}  // namespace
}  // namespace gw::dr_ekf

// Where the wheels roll: an IMU that looks askew or sits elsewhere, a base that turns about a point
// of its own. None of it may be taken for a scale of the gyro
// (docs/adr/0024-where-the-wheels-roll.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {
namespace {

struct Rolling {
  const char* name;
  double crab;
  double turn_centre;  // m
};
void PrintTo(const Rolling& rolling, std::ostream* os) {
  *os << rolling.name;
}

class Rolls : public testing::TestWithParam<Rolling> {};
INSTANTIATE_TEST_SUITE_P(All, Rolls,
                         testing::Values(Rolling{"as_calibrated", 0, 0}, Rolling{"askew", 0.02, 0},
                                         Rolling{"turns_ahead", 0, 0.03},
                                         Rolling{"turns_behind", 0, -0.03}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(Rolls, TheTurnStaysThatOfTheGyro) {
  const SimOptions options{
      .seed = 12, .duration_s = 80, .crab = GetParam().crab, .turn_centre = GetParam().turn_centre};
  const Recording r = Simulate(WheelsAndImu(), {}, options);
  DrFilter filter = std::move(DrFilter::Create({}, r.calibration)).value();
  const std::vector<DrState> states = FeedAll(filter, r.samples);
  double error = 0, truth = 0;
  for (size_t i = 1; i < states.size(); ++i) {
    const SE3 step = states[i - 1].T_OB.inverse() * states[i].T_OB;
    const SE3 true_step = r.TruthAt(states[i - 1].utime).inverse() * r.TruthAt(states[i].utime);
    error += LogSO3(step.rotation()).z() - LogSO3(true_step.rotation()).z();
    truth += std::abs(LogSO3(true_step.rotation()).z());
  }
  std::printf("%s: turned by %.1f rad in all, wrong by %.4f rad; turn scale %.4f +- %.4f\n",
              GetParam().name, truth, error, states.back().turn_scale,
              states.back().turn_scale_sigma);
  EXPECT_LT(std::abs(states.back().turn_scale - 1), 3 * states.back().turn_scale_sigma);
  EXPECT_LT(std::abs(error), 0.03);
}

// Wheels of unequal diameter turn the robot by so much per metre: no bias of the gyro, which is
// told by nothing else while the robot drives on and on.
TEST(DrRolls, UnequalWheelsAreNoBiasOfTheGyro) {
  SimOptions options{.seed = 21, .duration_s = 80, .parked_s = 3, .stops = false};
  options.turn_per_way = 0.015;  // rad/m
  options.gyro_bias.setConstant(0.01);
  const Recording r = Simulate(WheelsAndGyro(), {}, options);
  DrFilter filter = std::move(DrFilter::Create({}, r.calibration)).value();
  std::vector<DrDiagnosis> found;
  DrState first, last;
  for (const Sample& sample : r.samples) {
    DrFilter::Output out = Feed(filter, sample);
    found.insert(found.end(), out.found.begin(), out.found.end());
    for (const DrState& state : out.states) {
      if ((state.utime - r.begin).seconds() < 2.9) first = state;
      last = state;
    }
  }
  const SE3 motion = first.T_OB.inverse() * last.T_OB;
  const SE3 truth = r.TruthAt(first.utime).inverse() * r.TruthAt(last.utime);
  const double error = LogSO3(motion.rotation().conjugate() * truth.rotation()).z();
  std::printf("heading wrong by %.4f rad after 80 s, gyro bias by %.5f rad/s\n", error,
              (last.gyro_bias_rad_s - options.gyro_bias).norm());
  EXPECT_LT(std::abs(error), 0.03);
  EXPECT_EQ(std::count(found.begin(), found.end(), DrDiagnosis::kParted), 0);
}

// Somebody pushes a driving robot aside: that is no place where its wheels roll, and nothing that
// its accelerometer is to be blamed for.
TEST(DrRolls, APushIsNotTakenForAMounting) {
  for (const uint64_t seed : {3, 4, 5, 6}) {
    SimOptions options{.seed = seed, .duration_s = 40, .stops = false};
    options.slips = {{.begin_s = 15, .end_s = 16, .ramp_s = 0.1, .push_y = 0.15, .push_w = 0.2}};
    const Recording r = Simulate(WheelsAndImu(), {}, options);
    DrFilter filter = std::move(DrFilter::Create({}, r.calibration)).value();
    std::vector<DrDiagnosis> found;
    DrState before, last;
    for (const Sample& sample : r.samples) {
      DrFilter::Output out = Feed(filter, sample);
      found.insert(found.end(), out.found.begin(), out.found.end());
      for (const DrState& state : out.states) {
        const double t = (state.utime - r.begin).seconds();
        if (t < 20) before = state;
        if (t < 35) last = state;
      }
    }
    EXPECT_EQ(std::count(found.begin(), found.end(), DrDiagnosis::kAccelUnfit), 0) << seed;
    const SE3 motion = before.T_OB.inverse() * last.T_OB;
    const SE3 truth = r.TruthAt(before.utime).inverse() * r.TruthAt(last.utime);
    std::printf("seed %d: 15 s after the push wrong by %.3f m, %.4f rad\n", static_cast<int>(seed),
                (motion.translation() - truth.translation()).norm(),
                LogSO3(motion.rotation().conjugate() * truth.rotation()).norm());
    EXPECT_LT((motion.translation() - truth.translation()).head<2>().norm(), 0.1) << seed;
  }
}

}  // namespace
}  // namespace gw::dr_ekf

// Where the wheels roll: an IMU that looks askew or sits elsewhere, a base that turns about a point
// of its own. None of it may be taken for a scale of the gyro
// (docs/adr/0024-where-the-wheels-roll.md).
#include <gtest/gtest.h>

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
  Eigen::Vector2d turn_centre;
};
void PrintTo(const Rolling& rolling, std::ostream* os) {
  *os << rolling.name;
}

class Rolls : public testing::TestWithParam<Rolling> {};
INSTANTIATE_TEST_SUITE_P(All, Rolls,
                         testing::Values(Rolling{"as_calibrated", 0, {0, 0}},
                                         Rolling{"askew", 0.02, {0, 0}},
                                         Rolling{"turns_ahead", 0, {0.03, 0}},
                                         Rolling{"turns_behind", 0, {-0.03, 0}},
                                         Rolling{"turns_beside", 0, {0, 0.02}}),
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

}  // namespace
}  // namespace gw::dr_ekf

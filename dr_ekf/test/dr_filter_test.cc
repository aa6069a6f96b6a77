#include "dr_ekf/core/dr_filter.h"

#include <gtest/gtest.h>

#include <cstring>

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

}  // namespace
}  // namespace gw::dr_ekf

// Slip that the filter finds without a camera.
#include <gtest/gtest.h>

#include <cmath>

#include "dr_ekf/test/filter_testing.h"

namespace gw::dr_ekf {
namespace {

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

}  // namespace
}  // namespace gw::dr_ekf

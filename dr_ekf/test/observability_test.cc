// Which biases and scales the filter can find, with which sensors.
#include <gtest/gtest.h>

#include <cstdio>

#include "dr_ekf/test/filter_testing.h"

namespace gw::dr_ekf {
namespace {

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

}  // namespace
}  // namespace gw::dr_ekf

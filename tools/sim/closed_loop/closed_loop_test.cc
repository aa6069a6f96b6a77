// The whole system drives: short, in an office, with a box in the way that the map does not have.
#include "tools/sim/closed_loop/closed_loop.h"

#include <gtest/gtest.h>

#include "tools/robot/navigate/navigator.h"
#include "tools/sim/sim/scenario.h"

namespace gw::sim {
namespace {

TEST(ClosedLoop, GoesAroundABoxOnItsOwnPoses) {
  const std::string map_path =
      std::string(GW_SOURCE_DIR) + "/config/scenarios/maps/office/map.yaml";
  auto scenario = ParseScenario(
      "name: box\n"
      "waypoints: [[2.0, 2.0, 0.0], [5.5, 1.9, 0.0]]\n"
      "max_duration_s: 60\n"
      "camera: {mode: rgbd, rate_hz: 6}\n"
      "world:\n"
      "  boxes: [[3.8, 1.9, 0, 0.38, 0.38, 0.5]]\n",
      "box.yaml");
  ASSERT_TRUE(scenario.ok()) << scenario.error().message;
  scenario->map = map_path;
  const auto map = floorplan::LoadFloorMap(map_path);
  ASSERT_TRUE(map.ok());
  auto sim = Simulation::Create(*scenario, *map, Drive::kExternal, {1'000'000'000}, 2);
  ASSERT_TRUE(sim.ok()) << sim.error().message;
  const RobotConfig config = (*sim)->robot_config();
  auto navigator = navigate::Navigator::Create(config.navigate, *map, scenario->waypoints, {1});
  ASSERT_TRUE(navigator.ok());
  ClosedLoopOptions options;
  options.rates = {0.1, 0.087};
  auto loop = ClosedLoop::Create(*std::move(sim), config, {},
                                 std::make_unique<navigate::Navigator>(*std::move(navigator)),
                                 SE3(), navigate::MapFromWorld(scenario->waypoints[0]), options);
  ASSERT_TRUE(loop.ok()) << loop.error().message;
  double widest = 0;  // m beside the straight way
  (*loop)->on_truth = [&](const navigate::RobotPose& truth) {
    if (std::abs(truth.position.x() - 3.8) < 0.2) {
      widest = std::max(widest, std::abs(truth.position.y() - 1.9));
    }
  };
  (*loop)->Run([](double) { return true; });
  EXPECT_EQ((*loop)->report().reached, 1);
  EXPECT_EQ((*loop)->report().contacts, 0);
  EXPECT_GT(widest, 0.19 + config.navigate.robot_radius_m);
  // A wheel or IMU message every 5 ms at most: 0.5 mm; 10 ms where one is late.
  EXPECT_LE((*loop)->steps().published().m, 0.0011);
  EXPECT_EQ((*loop)->steps().not_covered(), 0);
}

}  // namespace
}  // namespace gw::sim

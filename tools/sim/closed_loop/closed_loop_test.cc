// The whole system drives: short, in an office, with a box in the way that the map does not have.
#include "tools/sim/closed_loop/closed_loop.h"

#include <gtest/gtest.h>

#include "tools/robot/navigate/navigator.h"
#include "tools/sim/sim/scenario.h"

namespace gw::sim {
namespace {

// A drive of 3.5 m in the office, with a box in the middle of the way.
Result<std::unique_ptr<ClosedLoop>> TowardsABox(bool obstacles) {
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
  if (!scenario) return scenario.error();
  scenario->map = map_path;
  const auto map = floorplan::LoadFloorMap(map_path);
  if (!map) return map.error();
  auto sim = Simulation::Create(*scenario, *map, Drive::kExternal, {1'000'000'000}, 2);
  if (!sim) return sim.error();
  const RobotConfig config = (*sim)->robot_config();
  auto navigator = navigate::Navigator::Create(config.navigate, *map, scenario->waypoints, {1});
  if (!navigator) return navigator.error();
  ClosedLoopOptions options;
  options.obstacles = obstacles;
  options.rates = {0.1, 0.087};
  return ClosedLoop::Create(*std::move(sim), config, {},
                            std::make_unique<navigate::Navigator>(*std::move(navigator)), SE3(),
                            navigate::MapFromWorld(scenario->waypoints[0]), options);
}

TEST(ClosedLoop, GoesAroundABoxOnItsOwnPoses) {
  auto loop = TowardsABox(true);
  ASSERT_TRUE(loop.ok()) << loop.error().message;
  double widest = 0;  // m beside the straight way
  (*loop)->on_truth = [&](const navigate::RobotPose& truth) {
    if (std::abs(truth.position.x() - 3.8) < 0.2) {
      widest = std::max(widest, std::abs(truth.position.y() - 1.9));
    }
  };
  (*loop)->Run([](double) { return true; });
  EXPECT_EQ((*loop)->report().reached, 1);
  EXPECT_TRUE((*loop)->report().contacts.empty());
  EXPECT_GT(widest, 0.19 + NavigateConfig{}.robot_radius_m);
  // A wheel or IMU message every 5 ms at most: 0.5 mm; 10 ms where one is late.
  EXPECT_LE((*loop)->steps().published().m, 0.0011);
  EXPECT_EQ((*loop)->steps().not_covered(), 0);
}

TEST(ClosedLoop, SaysWhereItTouchedWhatItWasNotShown) {
  auto loop = TowardsABox(false);
  ASSERT_TRUE(loop.ok()) << loop.error().message;
  (*loop)->Run([&](double) { return (*loop)->report().contacts.empty(); });
  ASSERT_EQ((*loop)->report().contacts.size(), 1u);
  const Contact& contact = (*loop)->report().contacts.front();
  EXPECT_GT(contact.seconds, 3);
  // Before the cells of 0.1 m that the box covers a part of.
  EXPECT_NEAR(contact.truth.position.x(), 3.6 - NavigateConfig{}.robot_radius_m, 0.1);
  EXPECT_NEAR(contact.truth.position.y(), 1.9, 0.2);
  EXPECT_LT(contact.pose_error_m, 0.05);
}

}  // namespace
}  // namespace gw::sim

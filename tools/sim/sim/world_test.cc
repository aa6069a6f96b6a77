#include "tools/sim/sim/world.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tools/robot/floorplan/test_room.h"

namespace gw::sim {
namespace {

World Furnished(uint64_t seed) {
  WorldConfig config;
  config.walls = WallStyle::kTextured;
  return World(floorplan::RoomForTest(), config, {1, 1}, {}, seed);
}

double AreaOf(const floorplan::FloorMap& map) {
  return static_cast<double>(std::count(map.occupied.begin(), map.occupied.end(), 1)) *
         map.resolution * map.resolution;
}

TEST(World, ATallRobotTouchesWhateverStandsAndALowOnePassesUnderDesks) {
  const floorplan::FloorMap plan = floorplan::RoomForTest();
  double under_desks = 0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const World world = Furnished(seed);
    const floorplan::FloorMap tall = world.Contacts(2.5), low = world.Contacts(0.42);
    ASSERT_LE(low.resolution, World::kContactCell);
    for (int i = 0; i < static_cast<int>(low.occupied.size()); ++i) {
      const Eigen::Vector2i cell = plan.CellOf(low.CentreOf(i % low.width, i / low.width));
      ASSERT_LE(plan.occupied[plan.index(cell.x(), cell.y())], low.occupied[i]);
      ASSERT_LE(low.occupied[i], tall.occupied[i]);
    }
    EXPECT_LE(AreaOf(tall), AreaOf(world.obstacles()));
    under_desks += AreaOf(tall) - AreaOf(low);
  }
  EXPECT_GT(under_desks, 0.2);
}

}  // namespace
}  // namespace gw::sim

// On ground truth: all waypoints of both maps of ../shared, without touching a wall.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "tools/robot/floorplan/boxes_in_the_way.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/navigate/test_drive.h"

namespace gw::navigate {
namespace {

void VisitAll(const std::string& name, const std::string& path_file) {
  const std::string folder = std::string(GW_SOURCE_DIR) + "/../shared/maps/" + name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no map at " << folder;
  const auto map = floorplan::LoadFloorMap(folder + "/map.yaml");
  ASSERT_TRUE(map.ok()) << map.error().message;
  const auto waypoints = floorplan::LoadWaypoints(folder + "/waypoints.txt");
  ASSERT_TRUE(waypoints.ok()) << waypoints.error().message;
  const auto tour =
      floorplan::LoadVisitOrder(folder + "/" + path_file, static_cast<int>(waypoints->size()));
  ASSERT_TRUE(tour.ok()) << tour.error().message;
  auto navigator = Navigator::Create({}, *map, *waypoints, *tour);
  ASSERT_TRUE(navigator.ok()) << navigator.error().message;
  // A robot of finite size cannot start in a wall: it starts where it will stop.
  floorplan::Waypoint start = (*waypoints)[tour->front()];
  start = floorplan::MoveStopsFromWalls(*map, {start}, NavigateConfig{}.robot_radius_m + 0.02)[0];
  TestDrive drive(*std::move(navigator), *map, start);
  drive.RunUntil(3600);
  std::printf("%s %s: %d of %d stops, %d contacts, %.0f s\n", name.c_str(), path_file.c_str(),
              drive.Count(EventKind::kReached), drive.navigator().num_stops(),
              drive.Count(EventKind::kBumped), drive.seconds());
  EXPECT_EQ(drive.Count(EventKind::kReached), drive.navigator().num_stops());
  EXPECT_FALSE(drive.bumped());
}

TEST(SharedMaps, SmallHouse) {
  VisitAll("aws_small_house", "path0.txt");
}

TEST(SharedMaps, FourthFloor) {
  VisitAll("tsrb_fourth_floor", "path0.txt");
}

TEST(SharedMaps, FourthFloorBackwards) {
  VisitAll("tsrb_fourth_floor", "path1.txt");
}

// Six boxes of 0.4 m in the way that the map does not have, at other places for every seed.
TEST(SharedMaps, SmallHouseWithBoxesInTheWay) {
  const std::string folder = std::string(GW_SOURCE_DIR) + "/../shared/maps/aws_small_house";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no map at " << folder;
  const auto map = floorplan::LoadFloorMap(folder + "/map.yaml");
  const auto waypoints = floorplan::LoadWaypoints(folder + "/waypoints.txt");
  ASSERT_TRUE(map.ok() && waypoints.ok());
  const NavigateConfig config;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    constexpr double kSide = 0.4;
    const auto boxes = floorplan::PlacesInTheWay(
        *map, *waypoints, config.robot_radius_m + config.clearance_m, kSide, 6, seed);
    ASSERT_EQ(boxes.size(), 6u);
    floorplan::FloorMap world = *map;
    for (const auto& box : boxes) world = floorplan::WithBox(world, box, kSide);
    const std::vector<int> tour =
        floorplan::StopsOfLaps(static_cast<int>(waypoints->size()), {}, 1);
    auto navigator = Navigator::Create(config, *map, *waypoints, tour);
    ASSERT_TRUE(navigator.ok());
    const floorplan::Waypoint start = floorplan::MoveStopsFromWalls(
        *map, {(*waypoints)[0]}, config.robot_radius_m + config.clearance_m)[0];
    TestDrive drive(*std::move(navigator), world, start, true);
    drive.RunUntil(1200);
    std::printf("seed %d: %d of %d stops, %d contacts, %d times blocked, %.0f s\n",
                static_cast<int>(seed), drive.Count(EventKind::kReached),
                drive.navigator().num_stops(), drive.Count(EventKind::kBumped),
                drive.Count(EventKind::kBlocked), drive.seconds());
    EXPECT_EQ(drive.Count(EventKind::kReached), drive.navigator().num_stops());
    EXPECT_FALSE(drive.bumped());
  }
}

}  // namespace
}  // namespace gw::navigate

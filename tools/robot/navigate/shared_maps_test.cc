// On ground truth: all waypoints of both maps of ../shared, without touching a wall.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

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

}  // namespace
}  // namespace gw::navigate

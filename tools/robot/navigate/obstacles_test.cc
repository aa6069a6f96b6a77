// Obstacles that the map does not have: seen, driven around, waited for, given up.
#include <gtest/gtest.h>

#include <algorithm>

#include "tools/robot/floorplan/test_room.h"
#include "tools/robot/navigate/navigator.h"
#include "tools/robot/navigate/test_drive.h"

namespace gw::navigate {
namespace {

using floorplan::FloorMap;
using floorplan::RoomForTest;
using floorplan::Waypoint;

const std::vector<Waypoint> kStops = {{{1.0, 1.0}, 0}, {{4.8, 1.0}, 1.57}, {{4.8, 4.0}, 3.14}};

TestDrive LookingDrive(const std::vector<int>& tour, FloorMap world) {
  auto navigator = Navigator::Create({}, RoomForTest(), kStops, tour);
  EXPECT_TRUE(navigator.ok());
  return TestDrive(*std::move(navigator), std::move(world), kStops[0], true);
}

// The room with a wall across it at x = 3.6 m.
FloorMap DividedRoom() {
  FloorMap world = RoomForTest();
  for (int y = 0; y < 50; ++y) world.occupied[world.index(36, y)] = 1;
  return world;
}

TEST(Obstacles, AreDrivenAroundWithoutTouchingThem) {
  FloorMap world = RoomForTest();
  for (int y = 8; y < 13; ++y) world.occupied[world.index(30, y)] = 1;  // on the way to 1
  TestDrive drive = LookingDrive({1, 2}, world);
  drive.RunUntil(120);
  EXPECT_EQ(drive.Count(EventKind::kReached), 2);
  EXPECT_FALSE(drive.bumped());
  EXPECT_EQ(drive.Count(EventKind::kBlocked), 0);
}

TEST(Obstacles, WhatWalksOnIsWaitedFor) {
  TestDrive drive = LookingDrive({1}, DividedRoom());
  while (drive.Count(EventKind::kBlocked) == 0 && drive.seconds() < 60) {
    drive.RunUntil(drive.seconds() + 0.1);
  }
  ASSERT_EQ(drive.Count(EventKind::kBlocked), 1);
  drive.RunUntil(drive.seconds() + 1);
  EXPECT_EQ(drive.command().v, 0);
  for (int y = 5; y < 20; ++y) drive.SetOccupied({36, y}, false);
  drive.RunUntil(drive.seconds() + 60);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
  EXPECT_FALSE(drive.bumped());
}

TEST(Obstacles, AWayThatIsWalledOffIsGivenUpAndSaidSo) {
  TestDrive drive = LookingDrive({1, 0}, DividedRoom());
  drive.RunUntil(400);
  ASSERT_TRUE(drive.navigator().finished());
  EXPECT_FALSE(drive.bumped());
  EXPECT_EQ(drive.navigator().num_unreachable(), 1);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
  const auto given_up = std::find_if(drive.events.begin(), drive.events.end(), [](const Event& e) {
    return e.kind == EventKind::kUnreachable;
  });
  ASSERT_NE(given_up, drive.events.end());
  EXPECT_FALSE(given_up->reason.empty());
  EXPECT_EQ(given_up->stop, 0);
}

TEST(Obstacles, AStopThatIsTooNearToOneIsVisitedFromBesideIt) {
  FloorMap world = RoomForTest();
  for (int y = 39; y < 41; ++y) {
    for (int x = 50; x < 52; ++x) world.occupied[world.index(x, y)] = 1;  // 0.2 m from stop 2
  }
  TestDrive drive = LookingDrive({2}, world);
  drive.RunUntil(120);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
  EXPECT_FALSE(drive.bumped());
}

TEST(Obstacles, WhereItSeesNoFloorItDrivesSlowly) {
  TestDrive drive = LookingDrive({1}, RoomForTest());
  drive.blind = [](double t) { return t > 4; };
  drive.RunUntil(3.9);
  EXPECT_GT(drive.command().v, 0.4);
  drive.RunUntil(5);
  EXPECT_GT(drive.command().v, 0);
  EXPECT_LE(drive.command().v, NavigateConfig{}.blind_speed_m_s);
  drive.RunUntil(120);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

TEST(Obstacles, AnOldViewIsAsGoodAsNone) {
  TestDrive drive = LookingDrive({1}, RoomForTest());
  drive.RunUntil(3);
  EXPECT_GT(drive.command().v, 0.3);
  drive.looks = false;
  drive.RunUntil(4.5);
  EXPECT_GT(drive.command().v, 0);
  EXPECT_LE(drive.command().v, NavigateConfig{}.blind_speed_m_s);
}

TEST(ObstacleLayer, TakesNoiseOfTheMapsWallsForTheWalls) {
  const FloorMap map = RoomForTest();
  ObstacleLayer layer(map, 0.06);
  ObstacleView view;
  view.obstacles.emplace_back(0.0F, 0.0F);
  RobotPose at;
  at.position = {3.0, 0.22};  // The lower wall ends at y = 0.2 m.
  layer.See(view, at);
  EXPECT_EQ(layer.DistanceTo(at.position, 1), 1);
  at.position.y() = 0.35;
  layer.See(view, at);
  EXPECT_EQ(layer.DistanceTo(at.position, 1), 0);
  layer.Remember();
  layer.See(ObstacleView{}, at);
  const Eigen::Vector2i cell = map.CellOf(at.position);
  EXPECT_TRUE(layer.On(map).Occupied(cell.x(), cell.y()));
  layer.Forget();
  EXPECT_FALSE(layer.On(map).Occupied(cell.x(), cell.y()));
}

TEST(ObstacleLayer, AViewWithoutAPoseOfItsTimeIsNotUsed) {
  auto navigator = Navigator::Create({}, RoomForTest(), kStops, {1});
  ObstacleView view;
  view.utime = UtimeFromSeconds(2);
  EXPECT_FALSE(navigator->See(view));
  navigator->Push(RobotPose{UtimeFromSeconds(1.9), {1, 1}, 0, 0, 0});
  EXPECT_FALSE(navigator->See(view));
  navigator->Push(RobotPose{UtimeFromSeconds(1.97), {1, 1}, 0, 0, 0});
  EXPECT_TRUE(navigator->See(view));
}

}  // namespace
}  // namespace gw::navigate

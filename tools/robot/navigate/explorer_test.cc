// Exploration: whole buildings from nothing, and beginnings that cannot go well.
#include "tools/robot/navigate/explorer.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "tools/robot/explore/coverage.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/robot/floorplan/test_room.h"
#include "tools/robot/navigate/test_exploration.h"

namespace gw::navigate {
namespace {

using floorplan::FloorMap;
using floorplan::RoomForTest;
using floorplan::Waypoint;

const Waypoint kStart{{1.02, 1.03}, 0};

double SeenShare(const FloorMap& plan, const Waypoint& start, const TestExploration& drive) {
  const auto seen = explore::CoverageOf(plan, start.position, NavigateConfig{}.robot_radius_m,
                                        drive.explorer.map(), SE3());
  return seen.seen_m2 / seen.reachable_m2;
}

// The room with a wall across it at x = 3.6 m and an opening in it, so many cells of 0.1 m wide.
FloorMap TwoRooms(int opening) {
  FloorMap world = RoomForTest();
  for (int y = 0; y < 50; ++y) {
    if (y < 30 || y >= 30 + opening) world.occupied[world.index(36, y)] = 1;
  }
  return world;
}

TEST(Explorer, SeesARoomAndComesBackTouchingNothing) {
  TestExploration drive(RoomForTest(), kStart);
  drive.RunUntil(600);
  ASSERT_TRUE(drive.explorer.finished());
  EXPECT_TRUE(drive.explorer.succeeded()) << drive.explorer.Summary();
  EXPECT_FALSE(drive.bumped());
  EXPECT_FALSE(drive.entered_unknown());
  EXPECT_GT(SeenShare(RoomForTest(), kStart, drive), 0.98);
  EXPECT_LT((drive.base().position() - kStart.position).norm(), 0.2);
  EXPECT_EQ(drive.explorer.num_left(), 0);
}

TEST(Explorer, GoesThroughADoor) {
  const FloorMap world = TwoRooms(8);
  TestExploration drive(world, kStart);
  drive.RunUntil(600);
  ASSERT_TRUE(drive.explorer.finished());
  EXPECT_TRUE(drive.explorer.succeeded()) << drive.explorer.Summary();
  EXPECT_FALSE(drive.bumped());
  EXPECT_GT(SeenShare(world, kStart, drive), 0.97);
}

// Across the room lies a strip where vision does not know the place.
TEST(Explorer, LooksAgainAtWhatWasInViewWhileNothingWasAdded) {
  TestExploration drive(RoomForTest(), kStart);
  drive.blind = [](const Eigen::Vector2d& p) { return p.x() > 1.8 && p.x() < 3; };
  drive.RunUntil(600);
  ASSERT_TRUE(drive.explorer.finished());
  EXPECT_TRUE(drive.explorer.succeeded()) << drive.explorer.Summary();
  EXPECT_FALSE(drive.bumped());
  EXPECT_GT(SeenShare(RoomForTest(), kStart, drive), 0.98);
}

// In the middle of the opening stands a pillar of glass: with the room that was lost to it the
// second room cannot be entered any more.
TEST(Explorer, ChoosesViewsAndWaysWithWhatItTouched) {
  FloorMap world = TwoRooms(14);
  for (int y = 36; y < 38; ++y) world.occupied[world.index(36, y)] = 1;
  TestExploration drive(world, kStart);
  drive.invisible = [](const Eigen::Vector2d& p) {
    return p.x() > 3.5 && p.x() < 3.8 && p.y() > 3.5 && p.y() < 3.9;
  };
  drive.RunUntil(600);
  ASSERT_TRUE(drive.explorer.finished());
  EXPECT_TRUE(drive.explorer.succeeded()) << drive.explorer.Summary();
  EXPECT_GE(drive.Count(EventKind::kBumped), 1);
  EXPECT_LE(drive.Count(EventKind::kBumped), 2);
  EXPECT_EQ(drive.Count(EventKind::kBlocked), 0);
  EXPECT_EQ(drive.Count(EventKind::kUnreachable), 0);
}

TEST(Explorer, SaysWhatIsLeftWhenItIsCutOff) {
  TestExploration drive(TwoRooms(8), kStart);
  drive.RunUntil(30);
  ASSERT_FALSE(drive.explorer.finished());
  EXPECT_GT(drive.explorer.num_left(), 0);
  EXPECT_NE(drive.explorer.Summary().find("left"), std::string::npos);
}

TEST(Explorer, SaysWhatItCouldNotReachBehindADoorThatIsTooNarrow) {
  TestExploration drive(TwoRooms(3), kStart);
  drive.RunUntil(900);
  ASSERT_TRUE(drive.explorer.finished());
  EXPECT_TRUE(drive.explorer.succeeded());
  EXPECT_FALSE(drive.bumped());
  EXPECT_GT(drive.explorer.num_left(), 0);
  EXPECT_NE(drive.explorer.Summary().find("unreachable"), std::string::npos);
  ASSERT_EQ(drive.events.back().kind, EventKind::kFinished);
}

TEST(Explorer, IsEnclosedWhereItSeesNoFloorThatItCouldDriveTo) {
  FloorMap world = RoomForTest();
  for (int y = 5; y < 16; ++y) {
    for (int x = 5; x < 16; ++x) {
      const bool inside = x > 7 && x < 13 && y > 7 && y < 13;
      if (!inside && (x + y) % 3 != 0) world.occupied[world.index(x, y)] = 1;
    }
  }
  TestExploration drive(world, {{1.05, 1.05}, 0});
  drive.RunUntil(120);
  ASSERT_TRUE(drive.explorer.finished()) << drive.events.size();
  EXPECT_FALSE(drive.explorer.succeeded());
  EXPECT_NE(drive.explorer.Summary().find("enclosed"), std::string::npos)
      << drive.explorer.Summary();
  EXPECT_FALSE(drive.bumped());
}

TEST(Explorer, StandsAndSaysSoOnceWhenNoFloorMapComes) {
  TestExploration drive(RoomForTest(), kStart);
  drive.grid_comes = false;
  drive.RunUntil(60);
  EXPECT_EQ(drive.Count(EventKind::kHeld), 1);
  EXPECT_FALSE(drive.explorer.waits_for().empty());
  EXPECT_EQ(drive.way_m(), 0);
  drive.grid_comes = true;
  drive.RunUntil(600);
  EXPECT_EQ(drive.Count(EventKind::kResumed), 1);
  EXPECT_TRUE(drive.explorer.finished());
}

TEST(Explorer, StandsWhenTheFloorMapStopsComing) {
  TestExploration drive(RoomForTest(), kStart);
  drive.RunUntil(15);
  drive.grid_comes = false;
  drive.RunUntil(22);
  const double way = drive.way_m();
  drive.RunUntil(40);
  EXPECT_LT(drive.way_m() - way, 0.01);
  EXPECT_EQ(drive.Count(EventKind::kHeld), 1);
}

// All of the shared small house, from nothing.
TEST(Explorer, SeesTheSmallHouse) {
  const std::string folder = std::string(GW_SOURCE_DIR) + "/../shared/maps/aws_small_house";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no map at " << folder;
  const auto plan = floorplan::LoadFloorMap(folder + "/map.yaml");
  const auto waypoints = floorplan::LoadWaypoints(folder + "/waypoints.txt");
  ASSERT_TRUE(plan.ok() && waypoints.ok());
  const Waypoint start = floorplan::MoveStopsFromWalls(*plan, {(*waypoints)[0]}, 0.24).front();
  TestExploration drive(*plan, start);
  drive.RunUntil(2400);
  const double seen = SeenShare(*plan, start, drive);
  std::printf("%s, %.1f %% seen, %.0f m, %.0f s\n", drive.explorer.Summary().c_str(), 100 * seen,
              drive.way_m(), drive.seconds());
  EXPECT_TRUE(drive.explorer.succeeded());
  EXPECT_FALSE(drive.bumped());
  EXPECT_FALSE(drive.entered_unknown());
  EXPECT_GT(seen, 0.97);
}

}  // namespace
}  // namespace gw::navigate

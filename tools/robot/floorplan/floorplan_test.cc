#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/robot/floorplan/contours.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/robot/floorplan/test_room.h"

namespace gw::floorplan {
namespace {

using ::testing::HasSubstr;

// Cells within 0.05 m of a line through (2, 2) with this slope.
FloorMap SlantedWall(double slope) {
  FloorMap map;
  map.width = 200;
  map.height = 200;
  map.resolution = 0.1;
  map.occupied.assign(200 * 200, 0);
  for (int x = 20; x < 150; ++x) {
    const int y = 20 + static_cast<int>(std::floor(slope * (x - 20)));
    map.occupied[map.index(x, y)] = map.occupied[map.index(x, y + 1)] = 1;
  }
  return map;
}

TEST(Contours, ASlantedWallHasFourCornersNotAStaircase) {
  for (const double slope : {0.0, 0.03, 0.11, 0.37, 0.5, 0.81}) {
    const FloorMap map = SlantedWall(slope);
    const auto contours = TraceContours(map, 0.145);
    ASSERT_EQ(contours.size(), 1u);
    EXPECT_LE(contours[0].vertices.size(), 6u) << slope;
  }
}

TEST(Contours, TheFreeSideIsOnTheRight) {
  const FloorMap map = RoomForTest();
  const auto contours = TraceContours(map, 0.145);
  ASSERT_EQ(contours.size(), 3u);  // outside, inside, pillar
  for (const Contour& contour : contours) {
    EXPECT_EQ(contour.vertices.size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d a = contour.vertices[i], b = contour.vertices[(i + 1) % 4];
      const Eigen::Vector2d d = (b - a).normalized();
      const Eigen::Vector2d right(d.y(), -d.x());
      const Eigen::Vector2i free = map.CellOf(0.5 * (a + b) + 0.05 * right);
      const Eigen::Vector2i wall = map.CellOf(0.5 * (a + b) - 0.05 * right);
      EXPECT_FALSE(map.Occupied(free.x(), free.y()));
      EXPECT_TRUE(map.Occupied(wall.x(), wall.y()));
    }
  }
}

TEST(Planner, EveryPointOfTheWayKeepsItsDistance) {
  const FloorMap map = RoomForTest();
  const auto distance = DistanceToOccupied(map, 5);
  const auto legs = PlanLegs(map, {{{0.7, 2.4}, 0}, {{5.2, 2.5}, 0}, {{2.9, 4.2}, 0}}, 0.24);
  ASSERT_TRUE(legs.ok());
  ASSERT_EQ(legs->size(), 2u);
  for (const Leg& leg : *legs) {
    for (const Eigen::Vector2d& p : leg) EXPECT_GE(DistanceAt(map, distance, p), 0.19);
  }
  EXPECT_LT((legs->front().back() - Eigen::Vector2d(5.2, 2.5)).norm(), 1e-6);
}

TEST(Planner, AStopCloseToAWallIsMovedAStopInsideIsNot) {
  const FloorMap map = RoomForTest();
  const auto stops =
      MoveStopsFromWalls(map, {{{0.32, 2.5}, 1}, {{2.9, 2.5}, 2}, {{1, 1}, 3}}, 0.24);
  EXPECT_GE(DistanceAt(map, DistanceToOccupied(map, 5), stops[0].position), 0.2);
  EXPECT_LT((stops[0].position - Eigen::Vector2d(0.32, 2.5)).norm(), 0.3);
  EXPECT_EQ(stops[1].position, Eigen::Vector2d(2.9, 2.5));
  EXPECT_EQ(stops[2].position, Eigen::Vector2d(1, 1));
}

// The pillar's row of RoomForTest, y 2.2 to 2.8 m, is unknown from wall to wall but for a gap.
FloorMap RoomWithUnknownBand(int gap_x) {
  FloorMap map = RoomForTest();
  map.unknown.assign(map.occupied.size(), 0);
  for (int y = 22; y < 28; ++y) {
    for (int x = 2; x < 58; ++x) map.unknown[map.index(x, y)] = std::abs(x - gap_x) < 4 ? 0 : 1;
  }
  return map;
}

TEST(Planner, UnknownCellsAreDrivenAroundWithTheRobotsClearance) {
  const FloorMap map = RoomWithUnknownBand(52);
  const auto legs = PlanLegs(map, {{{1, 1}, 0}, {{1, 4}, 0}}, 0.24);
  ASSERT_TRUE(legs.ok()) << legs.error().message;
  const auto distance = DistanceToNotFree(map, 5);
  for (const Eigen::Vector2d& p : legs->front()) EXPECT_GE(DistanceAt(map, distance, p), 0.19);
  EXPECT_GT(legs->front().size() * kLegSpacing, 8) << "straight on it would be 3 m";
}

TEST(Planner, EveryStopThatCannotBeVisitedIsNamedWithTheReason) {
  const FloorMap map = RoomWithUnknownBand(1000);
  const std::vector<Waypoint> stops = {{{1, 1}, 0}, {{1, 2.5}, 0}, {{1, 4}, 0},
                                       {{9, 1}, 0}, {{5, 1}, 0},   {{1, 2.13}, 0}};
  const Tour tour = PlanTour(map, stops, 0.24);
  EXPECT_THAT(tour.visited, ::testing::ElementsAre(0, 4));
  EXPECT_EQ(tour.legs.size(), 1u);
  const auto legs = PlanLegs(map, stops, 0.24);
  ASSERT_FALSE(legs.ok());
  EXPECT_THAT(legs.error().message,
              AllOf(HasSubstr("stop 1 at (1, 2.5) lies in unknown cells"),
                    HasSubstr("stop 2 at (1, 4) cannot be reached from (1, 1) but through unknown"),
                    HasSubstr("stop 3 at (9, 1) lies outside the map"),
                    HasSubstr("stop 5 at (1, 2.13) is nearer to unknown cells")));
}

TEST(Planner, AWayThroughAWallIsAnError) {
  FloorMap map = RoomForTest();
  for (int y = 0; y < 50; ++y) map.occupied[map.index(15, y)] = 1;
  const auto legs = PlanLegs(map, {{{0.8, 2.5}, 0}, {{5.2, 2.5}, 0}}, 0.24);
  ASSERT_FALSE(legs.ok());
  EXPECT_THAT(legs.error().message, HasSubstr("cannot be reached"));
}

}  // namespace
}  // namespace gw::floorplan

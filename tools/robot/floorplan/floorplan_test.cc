#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "grid/files/map_server.h"
#include "tools/robot/floorplan/contours.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/planner.h"
#include "tools/robot/floorplan/test_room.h"

namespace gw::floorplan {
namespace {

using ::testing::HasSubstr;

class FloorMapFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("floor_map_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string Write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return (folder_ / name).string();
  }
  std::string Yaml(const std::string& extra = "") {
    return Write("map.yaml",
                 "image: map.pgm\nresolution: 0.5\norigin: [-1, 2, 0]\nnegate: 0\n"
                 "occupied_thresh: 0.65\nfree_thresh: 0.196\n" +
                     extra);
  }
  std::filesystem::path folder_;
};

TEST_F(FloorMapFile, TheFirstRowOfTheImageIsTheTopOfTheMap) {
  Write("map.pgm", "P2\n# a comment\n3 2\n255\n0 254 205\n254 254 0\n");
  const auto map = LoadFloorMap(Yaml());
  ASSERT_TRUE(map.ok()) << map.error().message;
  EXPECT_TRUE(map->Occupied(0, 1));
  EXPECT_TRUE(map->Occupied(2, 0));
  EXPECT_FALSE(map->Occupied(2, 1)) << "unknown counts as free";
  EXPECT_EQ(map->CellOf({-0.9, 2.6}), Eigen::Vector2i(0, 1));
}

// What gw-grid saves is what gw-navigate drives on.
TEST_F(FloorMapFile, TheFloorMapOfTheGridIsReadBackCellByCell) {
  grid::FloorImage image{0.05, -7, 3, 5, 4, {}};
  for (int i = 0; i < image.width * image.height; ++i) {
    image.cells.push_back(i % 3 == 0   ? CellState::kOccupied
                          : i % 7 == 1 ? CellState::kUnknown
                                       : CellState::kFree);
  }
  ASSERT_TRUE(grid::WriteMapServer(folder_.string(), image).ok());
  const auto map = LoadFloorMap((folder_ / "map.yaml").string());
  ASSERT_TRUE(map.ok()) << map.error().message;
  ASSERT_EQ(map->width, image.width);
  ASSERT_EQ(map->height, image.height);
  EXPECT_EQ(map->resolution, image.cell_m);
  EXPECT_EQ(map->origin, image.cell_m * Eigen::Vector2d(image.first_x, image.first_y));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      EXPECT_EQ(map->Occupied(x, y), image.at(x, y) == CellState::kOccupied) << x << ", " << y;
    }
  }
}

TEST_F(FloorMapFile, BadFilesAreErrorsThatNameThem) {
  EXPECT_EQ(LoadFloorMap((folder_ / "none.yaml").string()).error().code, ErrorCode::kNotFound);
  const std::string yaml = Yaml();
  EXPECT_THAT(LoadFloorMap(yaml).error().message, HasSubstr("map.pgm: cannot open"));
  Write("map.pgm", "P5\n3 2\n255\nab");
  EXPECT_THAT(LoadFloorMap(yaml).error().message, HasSubstr("cut off"));
  Write("map.pgm", "P6\n3 2\n255\nabcdefghijklmnopqr");
  EXPECT_THAT(LoadFloorMap(yaml).error().message, HasSubstr("not an 8-bit grey image"));
  Write("map.pgm", "P2\n0 0\n255\n");
  EXPECT_THAT(LoadFloorMap(yaml).error().message, HasSubstr("not an 8-bit grey image"));
  Write("map.pgm", "P2\n2 1\n255\n254 254\n");
  EXPECT_THAT(LoadFloorMap(yaml).error().message, HasSubstr("map without walls"));
  const std::string bad = Write("bad.yaml", "image: map.pgm\nresolution: -1\n");
  EXPECT_EQ(LoadFloorMap(bad).error().code, ErrorCode::kBadConfig);
  EXPECT_THAT(LoadFloorMap(bad).error().message, HasSubstr("bad.yaml:1: `origin` is missing"));
}

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

TEST(Planner, AWayThroughAWallIsAnError) {
  FloorMap map = RoomForTest();
  for (int y = 0; y < 50; ++y) map.occupied[map.index(15, y)] = 1;
  const auto legs = PlanLegs(map, {{{0.8, 2.5}, 0}, {{5.2, 2.5}, 0}}, 0.24);
  ASSERT_FALSE(legs.ok());
  EXPECT_THAT(legs.error().message, HasSubstr("cannot be reached"));
}

}  // namespace
}  // namespace gw::floorplan

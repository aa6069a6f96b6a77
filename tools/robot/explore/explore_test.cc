#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/camera/camera_model.h"
#include "common/core/random.h"
#include "tools/robot/explore/blind_ring.h"
#include "tools/robot/explore/coverage.h"
#include "tools/robot/explore/frontiers.h"
#include "tools/robot/explore/looks.h"
#include "tools/robot/explore/sight_rays.h"
#include "tools/robot/explore/test_floor.h"
#include "tools/robot/explore/views.h"

namespace gw::explore {
namespace {

using Eigen::Vector2d;
using floorplan::FloorMap;
using floorplan::Waypoint;

constexpr double kRadius = 0.18, kClearance = 0.24, kLeastM = 0.36;

// A robot that is put down at every view that is chosen, without driving there.
struct Exploration {
  SeenFloor seen;
  LookCounts looks;
  int num_looks = 0;

  ViewSearch Search() const {
    ViewSearch search;
    search.sight = kTestSight;
    search.clearance_m = kClearance;
    search.least_m = kLeastM;
    search.looks = looks.On(seen.map());
    return search;
  }

  // Until there is no view left, 200 at most. cannot_see: this rectangle stays unknown.
  void Run(const Vector2d& start) {
    seen.Cover(start, 0.5);
    seen.LookAround(start, kTestSight);
    Vector2d at = start;
    while (num_looks < 200) {
      const auto views = FindViews(seen.map(), at, Search());
      if (views.empty()) return;
      CheckView(views.front());
      at = views.front().place.position;
      seen.Cover(at, kRadius);
      seen.Look(views.front().place, kTestSight);
      looks.Add(seen.map(), views.front().place, kTestSight, kLeastM);
      ++num_looks;
    }
  }

  void CheckView(const View& view) const {
    const FloorMap& map = seen.map();
    const auto room = floorplan::DistanceToNotFree(map, 1);
    const Eigen::Vector2i cell = map.CellOf(view.place.position);
    EXPECT_GE(room[map.index(cell.x(), cell.y())], kClearance - 1e-6);
    EXPECT_TRUE(std::isfinite(view.way_m));
    EXPECT_GT(view.unseen_m2, 0);
    EXPECT_GT(view.value, 0);
  }

  double SeenShare(const FloorMap& plan, const Vector2d& start) const {
    const Coverage c = CoverageOf(plan, start, kRadius, seen.map(), SE3());
    return c.seen_m2 / c.reachable_m2;
  }
  size_t FrontiersLeft() const { return FindFrontiers(seen.map(), {}, kLeastM).size(); }
};

TEST(Frontiers, AnEmptyOrUnknownOrWhollyKnownFloorHasNone) {
  EXPECT_TRUE(FindFrontiers({}, {}, kLeastM).empty());
  EXPECT_TRUE(FindViews({}, {1, 1}, {}).empty());
  EXPECT_TRUE(FindFrontiers(SeenFloor(TestRoom(4, 4)).map(), {}, kLeastM).empty());
  EXPECT_TRUE(FindFrontiers(TestRoom(4, 4), {}, kLeastM).empty());
}

TEST(Frontiers, LieWhereFreeFloorEndsInTheUnknown) {
  FloorMap map = TestRoom(6, 4);
  map.unknown.assign(map.occupied.size(), 0);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 60; x < map.width; ++x) {
      map.unknown[map.index(x, y)] = 1;
      map.occupied[map.index(x, y)] = 0;
    }
  }
  const auto frontiers = FindFrontiers(map, {}, kLeastM);
  ASSERT_EQ(frontiers.size(), 1u);
  EXPECT_NEAR(frontiers[0].middle.x(), 2.975, 1e-9);
  EXPECT_NEAR(frontiers[0].middle.y(), 2, 0.06);
  // Not along the walls, where the seam is.
  EXPECT_NEAR(0.05 * static_cast<double>(frontiers[0].cells.size()), 3.8 - 2 * kSeamM, 0.11);
  EXPECT_TRUE(FindFrontiers(map, {}, 4).empty());
  EXPECT_TRUE(FindFrontiers(map, std::vector<uint8_t>(map.occupied.size(), 1), kLeastM).empty());
}

TEST(Frontiers, TheSeamBeforeAWallIsNone) {
  FloorMap map = TestRoom(4, 4);
  map.unknown.assign(map.occupied.size(), 0);
  for (int y = 2; y < map.height - 2; ++y) {
    map.unknown[map.index(2, y)] = map.unknown[map.index(3, y)] = 1;
  }
  EXPECT_TRUE(FindFrontiers(map, {}, kLeastM).empty());
}

TEST(Views, ANearLookIsWorthMoreThanAFarOneThatShowsTheSame) {
  EXPECT_GT(ValueOf(2, 1), ValueOf(2, 3));
  EXPECT_GT(ValueOf(2, 1), ValueOf(1, 1));
}

TEST(Exploration, SeesTwoRoomsWhole) {
  const FloorMap plan = TwoRooms(0.9);
  Exploration e{SeenFloor(plan), {}};
  e.Run({1, 1});
  EXPECT_LE(e.num_looks, 15);
  EXPECT_GE(e.SeenShare(plan, {1, 1}), 0.99);
  EXPECT_EQ(e.FrontiersLeft(), 0u);
}

TEST(Exploration, DoesNotEnterADoorThatIsTooNarrow) {
  const FloorMap plan = TwoRooms(0.4);
  Exploration e{SeenFloor(plan), {}};
  e.Run({1, 1});
  EXPECT_LT(e.num_looks, 30);
  EXPECT_GE(e.SeenShare(plan, {1, 1}), 0.99);  // of what it can reach
  EXPECT_GE(e.FrontiersLeft(), 1u);            // in the room beyond
}

TEST(Exploration, ASpaceWithoutADoorIsNoTask) {
  FloorMap plan = TestRoom(6, 4);
  Fill(4, 0, 4.1, 4, 1, &plan);
  Exploration e{SeenFloor(plan), {}};
  e.Run({1, 1});
  EXPECT_LE(e.num_looks, 8);
  EXPECT_GE(e.SeenShare(plan, {1, 1}), 0.99);
  EXPECT_EQ(e.FrontiersLeft(), 0u);
}

// Rooms of random sizes, with doors and furniture: whatever the building, exploration ends, stands
// only where there is room, and sees what can be reached.
TEST(Exploration, SeesWhatCanBeReachedOfAnyRooms) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    CounterRng rng(seed, 0xE8, 0);
    FloorMap plan = TestRoom(9, 7);
    const double wall_x = rng.Uniform(3, 6), wall_y = rng.Uniform(2.5, 4.5);
    Fill(wall_x, 0, wall_x + 0.1, 7, 1, &plan);
    Fill(wall_x, wall_y, 9, wall_y + 0.1, 1, &plan);
    for (const double y : {rng.Uniform(0.2, wall_y - 1.1), rng.Uniform(wall_y + 0.2, 5.8)}) {
      Fill(wall_x, y, wall_x + 0.1, y + 0.9, 0, &plan);
    }
    for (int i = 0; i < 6; ++i) {
      const double x = rng.Uniform(2, 8), y = rng.Uniform(2, 6), side = rng.Uniform(0.1, 0.6);
      Fill(x, y, x + side, y + side, 1, &plan);
    }
    const Vector2d start(1, 1);
    Exploration e{SeenFloor(plan), {}};
    e.Run(start);
    EXPECT_LT(e.num_looks, 60) << seed;
    EXPECT_GE(e.SeenShare(plan, start), 0.97) << seed;
  }
}

// As glass, or a floor that no depth is found on.
TEST(Looks, AFrontierThatShowsNothingIsGivenUp) {
  SeenFloor seen(TestRoom(6, 4));
  seen.Cover({1.5, 2}, 0.5);
  seen.Look({{1, 2}, 0}, {0.6, 0.3, 1.5});
  LookCounts looks;
  ViewSearch search;
  search.sight = kTestSight;
  search.clearance_m = kClearance;
  search.least_m = kLeastM;
  int num_looks = 0;
  double last_range = kTestSight.max_range_m;
  for (; num_looks < 40; ++num_looks) {
    search.looks = looks.On(seen.map());
    const auto views = FindViews(seen.map(), {1.5, 2}, search);
    if (views.empty()) break;
    looks.Add(seen.map(), views.front().place, kTestSight, kLeastM);
    last_range = RangeLeft(kTestSight, kMostLooks - 1);
  }
  EXPECT_GE(num_looks, 2);
  EXPECT_LT(num_looks, 20);
  EXPECT_EQ(last_range, 1.5);
  EXPECT_FALSE(FindFrontiers(seen.map(), {}, kLeastM).empty());
  EXPECT_EQ(RangeLeft(kTestSight, kMostLooks), 0);
}

TEST(Looks, StayOnTheirFloorWhenTheMapGrows) {
  SeenFloor seen(TestRoom(6, 4));
  seen.Cover({1.5, 2}, 0.5);
  seen.Look({{1, 2}, 0}, {0.6, 0.3, 1.5});
  LookCounts looks;
  looks.Add(seen.map(), {{1, 2}, 0}, kTestSight, kLeastM);
  FloorMap larger;
  larger.resolution = 0.05;
  larger.origin = {-1, -2};
  larger.width = larger.height = 200;
  larger.occupied.assign(200 * 200, 0);
  const auto before = looks.On(seen.map()), after = looks.On(larger);
  int counted = 0;
  for (int y = 0; y < seen.map().height; ++y) {
    for (int x = 0; x < seen.map().width; ++x) {
      counted += before[seen.map().index(x, y)];
      EXPECT_EQ(before[seen.map().index(x, y)], after[larger.index(x + 20, y + 40)]);
    }
  }
  EXPECT_GT(counted, 0);
}

TEST(SightRays, SeeOverFreeFloorAndNotThroughWalls) {
  const FloorMap plan = TwoRooms(0.4);
  SeenFloor seen(plan);
  seen.Cover({2, 2}, 0.5);
  seen.LookAround({2, 2}, kTestSight);
  const auto open = OpenCells(seen.map());
  const std::vector<uint8_t> looks(open.size(), 0);
  const SightRays rays(seen.map(), open, looks, kTestSight);
  EXPECT_GT(rays.UnseenFrom({{3, 2}, 0}), 0.05);
  EXPECT_EQ(rays.UnseenFrom({{3, 3.2}, std::numbers::pi / 2}), 0);
  EXPECT_TRUE(rays.LooksPast({{3, 2}, 0}, {4.5, 2}));
  EXPECT_FALSE(rays.LooksPast({{3, 2}, std::numbers::pi}, {4.5, 2}));  // behind it
  EXPECT_FALSE(rays.LooksPast({{3, 3.5}, 0}, {4.5, 3.5}));             // behind the wall
  EXPECT_FALSE(rays.LooksPast({{3, 2}, 0}, {3.2, 2}));                 // too near
}

TEST(BlindRing, FloorIsFreeWhereFloorIsSeenBehindIt) {
  FloorMap plan = TestRoom(4, 4);
  Fill(2.2, 1.5, 2.4, 2.5, 1, &plan);  // nearer than the camera sees
  SeenFloor seen(plan);
  seen.Cover({2, 2}, 0.18);
  seen.LookAround({2, 2}, kTestSight);
  const auto free = FreeByLookingOver(seen.map(), {2, 2}, 0.6);
  ASSERT_FALSE(free.empty());
  for (const Vector2d& p : free) {
    EXPECT_LT((p - Vector2d(2, 2)).norm(), 0.65);
    const Eigen::Vector2i cell = plan.CellOf(p);
    EXPECT_FALSE(plan.Occupied(cell.x(), cell.y())) << p.transpose();
    EXPECT_TRUE(seen.map().Unknown(cell.x(), cell.y()));
  }
}

TEST(Sight, IsTheFloorThatTheCameraSees) {
  CameraGeometry geometry;
  RectifiedCamera& camera = geometry.rectified;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 400;
  camera.cx = 320;
  camera.cy = 240;
  camera.depth_max_m = 5;
  Eigen::Matrix3d R_BC;
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.T_BC = SE3(Eigen::Quaterniond(R_BC), {0.1, 0, 0.3});
  const auto sight = SightOf(geometry, {});
  ASSERT_TRUE(sight.ok());
  EXPECT_NEAR(sight->half_angle, 0.95 * std::atan(0.8), 1e-9);
  EXPECT_NEAR(sight->min_range_m, std::hypot(0.1 + 0.3 * 400 / 240, 0.5 * 0.8), 1e-9);
  EXPECT_NEAR(sight->max_range_m, 3, 1e-9);
  camera.T_BC = SE3(Eigen::Quaterniond(R_BC), {0.1, 0, 3});
  EXPECT_FALSE(SightOf(geometry, {}).ok());
}

}  // namespace
}  // namespace gw::explore

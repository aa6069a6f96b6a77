#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/camera/camera_model.h"
#include "common/core/random.h"
#include "tools/robot/explore/blind_ring.h"
#include "tools/robot/explore/coverage.h"
#include "tools/robot/explore/frontiers.h"
#include "tools/robot/explore/sight_rays.h"
#include "tools/robot/explore/test_floor.h"
#include "tools/robot/explore/vain_looks.h"
#include "tools/robot/explore/view_order.h"
#include "tools/robot/explore/views.h"

namespace gw::explore {
namespace {

using Eigen::Vector2d;
using floorplan::FloorMap;
using floorplan::Waypoint;

constexpr double kRadius = 0.18, kClearance = 0.24;

UnseenFloor Unseen(const FloorMap& map, const VainLooks& vain = {}) {
  return FindUnseenFloor(map, vain.On(map), kTestSight, kRadius);
}

std::vector<View> ViewsFrom(const UnseenFloor& floor, const Vector2d& from) {
  return FindViews(floor, from, {kClearance, {}});
}

View Next(const FloorMap& map, const std::vector<View>& views) {
  std::vector<double> first_m;
  for (const View& view : views) first_m.push_back(view.way_m);
  return views[static_cast<size_t>(FirstOfTour(map, views, first_m, kClearance))];
}

// A robot that is put down at every view that is chosen, without driving there.
struct Exploration {
  SeenFloor seen;
  VainLooks vain;
  int num_looks = 0;

  // Until there is no view left, 200 at most.
  void Run(const Vector2d& start) {
    seen.Cover(start, 0.5);
    seen.LookAround(start, kTestSight);
    Vector2d at = start;
    while (num_looks < 200) {
      const auto views = ViewsFrom(Unseen(seen.map(), vain), at);
      if (views.empty()) return;
      const View view = Next(seen.map(), views);
      CheckView(view);
      at = view.place.position;
      seen.Cover(at, kRadius);
      seen.Look(view.place, kTestSight);
      vain.Add(seen.map(), SightRays(Unseen(seen.map(), vain)).Glances(view.place));
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
  }

  double SeenShare(const FloorMap& plan, const Vector2d& start) const {
    const Coverage c = CoverageOf(plan, start, kRadius, seen.map(), SE3());
    return c.seen_m2 / c.reachable_m2;
  }
  size_t FrontiersLeft() const { return FindFrontiers(Unseen(seen.map())).size(); }
};

TEST(Frontiers, AnEmptyOrUnknownOrWhollyKnownFloorHasNone) {
  EXPECT_TRUE(FindFrontiers(Unseen({})).empty());
  EXPECT_TRUE(ViewsFrom(Unseen({}), {1, 1}).empty());
  EXPECT_TRUE(FindFrontiers(Unseen(SeenFloor(TestRoom(4, 4)).map())).empty());
  EXPECT_TRUE(FindFrontiers(Unseen(TestRoom(4, 4))).empty());
}

// A room whose cells in x from `begin` to `end` are unknown.
FloorMap RoomWithUnknown(int begin, int end) {
  FloorMap map = TestRoom(6, 4);
  map.unknown.assign(map.occupied.size(), 0);
  for (int y = 0; y < map.height; ++y) {
    for (int x = begin; x < end; ++x) {
      map.unknown[map.index(x, y)] = 1;
      map.occupied[map.index(x, y)] = 0;
    }
  }
  return map;
}

TEST(Frontiers, LieWhereFreeFloorEndsInTheUnknown) {
  const FloorMap map = RoomWithUnknown(60, 120);
  const auto frontiers = FindFrontiers(Unseen(map));
  ASSERT_EQ(frontiers.size(), 1u);
  EXPECT_NEAR(frontiers[0].middle.x(), 2.975, 1e-9);
  EXPECT_NEAR(frontiers[0].middle.y(), 2, 0.06);
  // Not along the walls, where the seam is.
  EXPECT_NEAR(0.05 * static_cast<double>(frontiers[0].cells.size()), 3.8 - 2 * kSeamM, 0.11);
  const auto of_wide_robot = FindFrontiers(FindUnseenFloor(map, {}, kTestSight, 2.5));
  EXPECT_TRUE(of_wide_robot.empty());
}

TEST(UnseenFloor, TheSeamBeforeAWallIsNone) {
  FloorMap map = TestRoom(4, 4);
  map.unknown.assign(map.occupied.size(), 0);
  for (int y = 2; y < map.height - 2; ++y) {
    map.unknown[map.index(2, y)] = map.unknown[map.index(3, y)] = 1;
  }
  EXPECT_TRUE(FindFrontiers(Unseen(map)).empty());
}

TEST(UnseenFloor, IsNotWhereTheRobotHasNoRoomWhateverIsThere) {
  const auto open_in_lane = [](int cells_wide) {
    FloorMap map = TestRoom(6, 4);
    map.unknown.assign(map.occupied.size(), 0);
    for (int x = 40; x < 110; ++x) {
      map.occupied[map.index(x, 30)] = map.occupied[map.index(x, 31 + cells_wide)] = 1;
      for (int y = 31; y < 31 + cells_wide; ++y) map.unknown[map.index(x, y)] = 1;
    }
    const UnseenFloor floor = Unseen(map);
    return std::count(floor.open.begin(), floor.open.end(), 1);
  };
  EXPECT_EQ(open_in_lane(7), 0);  // 0.35 m; the robot is 0.36 m wide
  EXPECT_GT(open_in_lane(9), 100);
}

TEST(UnseenFloor, IsNotASpotSmallerThanTheRobot) {
  FloorMap map = TestRoom(4, 4);
  map.unknown.assign(map.occupied.size(), 0);
  const auto with_spot = [&map](int side) {
    for (int y = 40; y < 40 + side; ++y) {
      for (int x = 40; x < 40 + side; ++x) map.unknown[map.index(x, y)] = 1;
    }
    return FindFrontiers(Unseen(map)).size();
  };
  EXPECT_EQ(with_spot(6), 0u);
  EXPECT_EQ(with_spot(8), 1u);
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
    ASSERT_LT(e.num_looks, 60) << seed;
    EXPECT_GE(e.SeenShare(plan, start), 0.97) << seed;
  }
}

SeenFloor PartOfARoom() {
  SeenFloor seen(TestRoom(6, 4));
  seen.Cover({1.5, 2}, 0.5);
  seen.Look({{1, 2}, 0}, {0.6, 0.3, 1.5});
  return seen;
}

// As glass, or a floor that no depth is found on.
TEST(VainLooks, AFrontierThatShowsNothingIsGivenUp) {
  const SeenFloor seen = PartOfARoom();
  VainLooks vain;
  int num_looks = 0;
  for (; num_looks < 40; ++num_looks) {
    const auto views = ViewsFrom(Unseen(seen.map(), vain), {1.5, 2});
    if (views.empty()) break;
    const auto glances = SightRays(Unseen(seen.map(), vain)).Glances(views.front().place);
    EXPECT_FALSE(glances.empty());
    vain.Add(seen.map(), glances);
  }
  EXPECT_GE(num_looks, 2);
  EXPECT_LT(num_looks, 20);
  EXPECT_FALSE(FindFrontiers(Unseen(seen.map())).empty());
}

TEST(VainLooks, TheSamePlaceIsNotWorthASecondLookAndHalfAsFarIs) {
  const SeenFloor seen = PartOfARoom();
  VainLooks vain;
  const Waypoint far{{1.2, 2}, 0}, near{{2.3, 2}, 0};
  const UnseenFloor before = Unseen(seen.map());
  EXPECT_GT(SightRays(before).UnseenFrom(far), 0.1);
  vain.Add(seen.map(), SightRays(before).Glances(far));
  const UnseenFloor after = Unseen(seen.map(), vain);
  EXPECT_EQ(SightRays(after).UnseenFrom(far), 0);
  EXPECT_GT(SightRays(after).UnseenFrom(near), 0.1);
}

TEST(VainLooks, OnTheWayOnlyWhatStayedInViewWasLookedAt) {
  const SeenFloor seen = PartOfARoom();
  const auto glances = SightRays(Unseen(seen.map())).Glances({{1.2, 2}, 0});
  const auto looked_at = [&](const VainLooks& vain) {
    const auto range = vain.On(seen.map());
    return std::count_if(range.begin(), range.end(), [](float r) { return r < kNeverLookedAt; });
  };
  VainLooks vain;
  vain.Watch(seen.map(), glances, {1'000'000});
  vain.Watch(seen.map(), {}, {1'500'000});
  vain.Watch(seen.map(), glances, {2'000'000});
  vain.Watch(seen.map(), glances, {2'500'000});
  EXPECT_EQ(looked_at(vain), 0);
  vain.Watch(seen.map(), glances, {2'500'000});  // no newer image: it is blind for a while
  vain.Watch(seen.map(), glances, {9'000'000});
  vain.Watch(seen.map(), glances, {9'500'000});
  EXPECT_EQ(looked_at(vain), 0);
  vain.Watch(seen.map(), glances, {10'000'000});
  EXPECT_GT(looked_at(vain), 0);
}

TEST(VainLooks, StayOnTheirFloorWhenTheMapGrows) {
  const SeenFloor seen = PartOfARoom();
  VainLooks vain;
  vain.Add(seen.map(), SightRays(Unseen(seen.map())).Glances({{1, 2}, 0}));
  FloorMap larger;
  larger.resolution = 0.05;
  larger.origin = {-1, -2};
  larger.width = larger.height = 200;
  larger.occupied.assign(200 * 200, 0);
  const auto before = vain.On(seen.map()), after = vain.On(larger);
  int looked_at = 0;
  for (int y = 0; y < seen.map().height; ++y) {
    for (int x = 0; x < seen.map().width; ++x) {
      looked_at += before[seen.map().index(x, y)] < kNeverLookedAt ? 1 : 0;
      EXPECT_EQ(before[seen.map().index(x, y)], after[larger.index(x + 20, y + 40)]);
    }
  }
  EXPECT_GT(looked_at, 0);
}

TEST(ViewOrder, BeginsTheShortestWayThroughAll) {
  EXPECT_EQ(FirstOfShortest({3}, {{0}}), 0);
  // On a line: places at 2 and at -3 and -4; the nearest first makes the way longer when the
  // rest lies behind it.
  const std::vector<double> at = {2, -3, -4, 2.5};
  std::vector<double> first;
  std::vector<std::vector<double>> way;
  for (const double a : at) {
    first.push_back(std::abs(a));
    way.emplace_back();
    for (const double b : at) way.back().push_back(std::abs(a - b));
  }
  EXPECT_EQ(FirstOfShortest(first, way), 0);
  first[0] += 5;
  first[3] += 5;
  EXPECT_EQ(FirstOfShortest(first, way), 1);
}

TEST(SightRays, SeeOverFreeFloorAndNotThroughWalls) {
  const FloorMap plan = TwoRooms(0.4);
  SeenFloor seen(plan);
  seen.Cover({2, 2}, 0.5);
  seen.LookAround({2, 2}, kTestSight);
  const UnseenFloor floor = Unseen(seen.map());
  const SightRays rays(floor);
  EXPECT_GT(rays.UnseenFrom({{3, 2}, 0}), 0.02);
  EXPECT_EQ(rays.UnseenFrom({{3, 3.2}, std::numbers::pi / 2}), 0);
  EXPECT_TRUE(rays.Sees({{3, 2}, 0}, {4.5, 2}));
  EXPECT_FALSE(rays.Sees({{3, 2}, std::numbers::pi}, {4.5, 2}));  // behind it
  EXPECT_FALSE(rays.Sees({{3, 3.5}, 0}, {4.5, 3.5}));             // behind the wall
  EXPECT_FALSE(rays.Sees({{3, 2}, 0}, {3.2, 2}));                 // too near
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

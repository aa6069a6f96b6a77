#include "tools/robot/navigate/navigator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/robot/floorplan/test_room.h"
#include "tools/robot/navigate/bus_time.h"
#include "tools/robot/navigate/test_drive.h"

namespace gw::navigate {
namespace {

using floorplan::FloorMap;
using floorplan::RoomForTest;
using floorplan::Waypoint;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<Waypoint> kCorners = {
    {{1.0, 1.0}, 0}, {{4.8, 1.0}, 1.57}, {{4.8, 4.0}, 3.14}, {{1.0, 4.0}, -1.57}};

TestDrive Drive(const std::vector<int>& tour, FloorMap world = RoomForTest(),
                const NavigateConfig& config = {}) {
  auto navigator = Navigator::Create(config, RoomForTest(), kCorners, tour);
  EXPECT_TRUE(navigator.ok());
  return TestDrive(*std::move(navigator), std::move(world), kCorners[0]);
}

TEST(Navigator, ReachesEveryStopInOrderWithinItsToleranceAndTouchesNothing) {
  TestDrive drive = Drive({0, 1, 2, 3, 0, 2});
  drive.RunUntil(300);
  ASSERT_TRUE(drive.navigator().finished());
  EXPECT_EQ(drive.navigator().num_unreachable(), 0);
  EXPECT_FALSE(drive.bumped());
  int stop = 0;
  for (size_t i = 0; i < drive.events.size(); ++i) {
    if (drive.events[i].kind != EventKind::kReached) continue;
    EXPECT_EQ(drive.events[i].stop, stop);
    const Waypoint& place = drive.navigator().place(stop++);
    EXPECT_LT((drive.truth_at_events[i].position - place.position).norm(), 0.1);
    EXPECT_LT(std::abs(floorplan::AngleTo(drive.truth_at_events[i].yaw, place.yaw)), 0.1);
  }
  EXPECT_EQ(stop, 6);
}

TEST(Navigator, StandsStillAtAStopForThePause) {
  NavigateConfig config;
  config.pause_s = 2;
  TestDrive drive = Drive({1, 2}, RoomForTest(), config);
  std::vector<Eigen::Vector2d> positions;  // every 0.1 s
  while (drive.Count(EventKind::kReached) == 0 && drive.seconds() < 100) {
    drive.RunUntil(drive.seconds() + 0.1);
    positions.push_back(drive.base().position());
  }
  ASSERT_GT(positions.size(), 20u);
  // The last 1.5 s of the pause; before, the base still reacts to the last turn.
  EXPECT_LT((positions.back() - positions[positions.size() - 16]).norm(), 1e-3);
}

TEST(Navigator, CommandsAStopWithin300MsOfTheLastPoseAndGoesOnWhenItIsBack) {
  TestDrive drive = Drive({1});
  bool silent = false;
  drive.view = [&](const RobotPose& truth) { return silent ? std::nullopt : std::optional(truth); };
  drive.RunUntil(4);
  ASSERT_GT(drive.command().v, 0.2);
  silent = true;
  drive.RunUntil(4.3);
  EXPECT_EQ(drive.command().v, 0);
  EXPECT_EQ(drive.command().w, 0);
  EXPECT_EQ(drive.navigator().pose_state(), PoseState::kStale);
  drive.RunUntil(10);
  EXPECT_EQ(drive.Count(EventKind::kHeld), 1) << "told once";
  EXPECT_LT(std::abs(drive.base().v()), 1e-3);
  silent = false;
  drive.RunUntil(60);
  EXPECT_EQ(drive.Count(EventKind::kResumed), 1);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

TEST(Navigator, StandsStillForLongWithoutGivingUp) {
  TestDrive drive = Drive({1});
  drive.view = [&](const RobotPose& truth) {
    return truth.utime < UtimeFromSeconds(200) ? std::nullopt : std::optional(truth);
  };
  drive.RunUntil(300);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

TEST(Navigator, LooksAroundForItsPlaceInTheMapTwiceAtMost) {
  auto navigator = Navigator::Create({}, RoomForTest(), kCorners, {1});
  ASSERT_TRUE(navigator.ok());
  double turned = 0, began = -1;
  for (int k = 0; k < 60 * Navigator::kRateHz; ++k) {
    const double t = static_cast<double>(k) / Navigator::kRateHz;
    navigator->Push(std::nullopt);
    const floorplan::Speed speed = navigator->Update(UtimeFromSeconds(t)).speed;
    EXPECT_EQ(speed.v, 0);
    turned += speed.w / Navigator::kRateHz;
    if (speed.w > 0 && began < 0) began = t;
  }
  EXPECT_NEAR(began, 2, 0.2);
  EXPECT_NEAR(turned, 13, 0.2);
}

TEST(Navigator, LooksAroundWhereItsPlaceIsInDoubt) {
  TestDrive drive = Drive({1});
  double turned = 0;
  Utime before;
  drive.view = [&](const RobotPose& truth) {
    RobotPose seen = truth;
    // From 4 s on nothing that it sees is in its map, until it has turned by 2 rad.
    const bool doubt = truth.utime > UtimeFromSeconds(4) && turned < 2;
    if (doubt) turned += drive.command().w * (truth.utime - before).seconds();
    before = truth.utime;
    seen.sigma_m = doubt ? 10 : 0.01;
    return seen;
  };
  drive.RunUntil(60);
  EXPECT_GE(turned, 2);
  EXPECT_EQ(drive.Count(EventKind::kResumed), 1);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

TEST(Navigator, PlansAnewWhenThePoseJumps) {
  TestDrive drive = Drive({1});
  // As if the map had been wrong by 0.8 m until t = 4 s.
  drive.view = [&](const RobotPose& truth) {
    RobotPose seen = truth;
    if (truth.utime < UtimeFromSeconds(4)) seen.position.y() += 0.8;
    return seen;
  };
  drive.RunUntil(60);
  EXPECT_GE(drive.Count(EventKind::kLeg), 2);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
  EXPECT_LT((drive.base().position() - kCorners[1].position).norm(), 0.2);
}

TEST(Navigator, BacksOffFromWhatTheMapDoesNotKnowAndGoesAround) {
  FloorMap world = RoomForTest();
  for (int y = 8; y < 13; ++y) world.occupied[world.index(30, y)] = 1;  // a box on the way to 1
  TestDrive drive = Drive({1}, world);
  double least_v = 0;
  while (!drive.navigator().finished() && drive.seconds() < 120) {
    drive.RunUntil(drive.seconds() + 0.05);
    least_v = std::min(least_v, drive.command().v);
  }
  EXPECT_TRUE(drive.bumped());
  EXPECT_GE(drive.Count(EventKind::kBumped), 1);
  EXPECT_LT(least_v, 0) << "tells the base that it noticed";
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

TEST(Navigator, GoesOnWhenAStopIsWalledOffFromWhatTheMapSays) {
  FloorMap world = RoomForTest();
  for (int y = 0; y < 50; ++y) world.occupied[world.index(36, y)] = 1;
  TestDrive drive = Drive({1, 3}, world);
  drive.RunUntil(600);
  ASSERT_TRUE(drive.navigator().finished());
  EXPECT_EQ(drive.navigator().num_unreachable(), 1);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

TEST(Navigator, GivesUpAStopThatComesNoNearer) {
  NavigateConfig config;
  config.give_up_s = 5;
  TestDrive drive = Drive({1, 2}, RoomForTest(), config);
  RobotPose stuck;
  drive.view = [&](const RobotPose& truth) {
    if (truth.utime < UtimeFromSeconds(3)) stuck = truth;
    stuck.utime = truth.utime;
    return stuck;
  };
  drive.RunUntil(60);
  ASSERT_TRUE(drive.navigator().finished());
  EXPECT_EQ(drive.navigator().num_unreachable(), 2);
}

TEST(Navigator, StandsWhileItIsLifted) {
  TestDrive drive = Drive({1});
  drive.extra_contact = [](double t) { return ContactFlags{.wheel_drop = t > 3 && t < 6}; };
  drive.RunUntil(5);
  EXPECT_EQ(drive.command().v, 0);
  ASSERT_EQ(drive.Count(EventKind::kHeld), 1);
  EXPECT_EQ(drive.events.back().reason, "lifted");
  drive.RunUntil(60);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
}

// Drives from `begin` to a stop that is nearer to a wall than the robot can stand.
void VisitBesideAWall(const Waypoint& begin, const Waypoint& stop) {
  const std::vector<Waypoint> waypoints = {begin, stop};
  auto navigator = Navigator::Create({}, RoomForTest(), waypoints, {1});
  ASSERT_TRUE(navigator.ok()) << navigator.error().message;
  TestDrive drive(*std::move(navigator), RoomForTest(), begin);
  drive.RunUntil(60);
  EXPECT_EQ(drive.Count(EventKind::kReached), 1);
  EXPECT_FALSE(drive.bumped());
}

TEST(Navigator, AStopCloseToAWallIsVisitedFromAsNearAsTheRobotCanStand) {
  VisitBesideAWall({{1.0, 1.0}, 0}, {{0.31, 2.5}, 3.14});
}

TEST(Navigator, DrivesOnUntilAStopThatWasMovedFromAWallCountsAsReached) {
  // It begins 0.22 m before the stop, 0.05 m before the nearest place where it can stand.
  VisitBesideAWall({{0.5, 2.45}, 0}, {{0.28, 2.45}, 0});
}

// A room that is walled off at x = 4.5 m and whose upper right corner nobody has mapped.
FloorMap PartlyKnownRoom() {
  FloorMap map = RoomForTest();
  for (int y = 0; y < 50; ++y) map.occupied[map.index(45, y)] = 1;
  map.unknown.assign(map.occupied.size(), 0);
  for (int y = 35; y < 48; ++y) {
    for (int x = 30; x < 45; ++x) map.unknown[map.index(x, y)] = 1;
  }
  return map;
}

TEST(Navigator, StopsThatNoRobotCanVisitAreAnErrorThatNamesThemAll) {
  const std::vector<Waypoint> stops = {{{2.85, 2.5}, 0}, {{50, 2}, 0}, {{3.8, 4}, 0}};
  const auto navigator = Navigator::Create({}, PartlyKnownRoom(), stops, {0, 1, 2});
  ASSERT_FALSE(navigator.ok());
  EXPECT_EQ(navigator.error().code, ErrorCode::kBadData);
  EXPECT_THAT(navigator.error().message,
              AllOf(HasSubstr("waypoint 0 of the tour cannot be visited: (2.85, 2.5) is in a wall"),
                    HasSubstr("waypoint 1"), HasSubstr("(50, 2) lies outside the map"),
                    HasSubstr("waypoint 2"), HasSubstr("(3.8, 4) lies in unknown cells")));
}

TEST(Navigator, StopsThatCannotBeVisitedAreNamedAndPassedOver) {
  const FloorMap map = PartlyKnownRoom();
  const std::vector<Waypoint> stops = {{{1, 1}, 0}, {{3.8, 4}, 0}, {{5.2, 2}, 0}, {{3.8, 1.2}, 0}};
  auto navigator = Navigator::Create({}, map, stops, {0, 1, 2, 3});
  ASSERT_TRUE(navigator.ok()) << navigator.error().message;
  EXPECT_THAT(navigator->complaints(),
              ElementsAre(HasSubstr("waypoint 1"), HasSubstr("(5.2, 2) cannot be reached")));
  TestDrive drive(*std::move(navigator), map, stops[0]);
  drive.RunUntil(120);
  ASSERT_TRUE(drive.navigator().finished());
  EXPECT_EQ(drive.Count(EventKind::kReached), 2);
  EXPECT_EQ(drive.navigator().num_unreachable(), 2);
}

RobotPose Uncertain(double sigma_m, double sigma_deg = 0) {
  return {Utime{0}, {0, 0}, 0, sigma_m, sigma_deg * 3.14159265 / 180};
}

TEST(PoseGuard, IsSlowerTheLessCertainThePoseIsAndStopsAtTheLimit) {
  const NavigateConfig config;
  PoseGuard guard(config);
  double before = 1;
  for (double sigma = 0; sigma < config.stop_sigma_m; sigma += 0.01) {
    const auto verdict = guard.Judge(Uncertain(sigma), Utime{0});
    EXPECT_EQ(verdict.state, PoseState::kGood) << sigma;
    EXPECT_LE(verdict.speed_share, before);
    before = verdict.speed_share;
  }
  EXPECT_NEAR(before, PoseGuard::kLeastShare, 0.05);
  EXPECT_EQ(guard.Judge(Uncertain(1.01 * config.stop_sigma_m), Utime{0}).state,
            PoseState::kUncertain);
  EXPECT_EQ(guard.Judge(Uncertain(0, 1.01 * config.stop_sigma_deg), Utime{0}).state,
            PoseState::kUncertain);
}

TEST(PoseGuard, DoesNotGoOnRightBelowTheLimit) {
  const NavigateConfig config;
  PoseGuard guard(config);
  ASSERT_EQ(guard.Judge(Uncertain(1.1 * config.stop_sigma_m), Utime{0}).state,
            PoseState::kUncertain);
  EXPECT_EQ(guard.Judge(Uncertain(0.9 * config.stop_sigma_m), Utime{0}).state,
            PoseState::kUncertain);
  EXPECT_EQ(guard.Judge(Uncertain(0.7 * config.stop_sigma_m), Utime{0}).state, PoseState::kGood);
}

TEST(PoseGuard, NoPoseIsNoReasonToDrive) {
  PoseGuard guard({});
  EXPECT_EQ(guard.Judge(std::nullopt, Utime{0}).state, PoseState::kNone);
  EXPECT_EQ(guard.Judge(RobotPose{}, Utime{160'000}).state, PoseState::kStale);
}

TEST(BusTime, IsThatOfTheSensorsAndGoesOnWhenTheyAreSilent) {
  BusTime time;
  EXPECT_FALSE(time.At(Utime{0}).has_value());
  time.Observe(Utime{5'000'000}, Utime{9'000'000});  // a world 4 s behind the clock
  EXPECT_EQ(*time.At(Utime{9'050'000}), Utime{5'000'000});
  EXPECT_EQ(*time.At(Utime{9'300'000}), Utime{5'200'000});
  time.Observe(Utime{4'900'000}, Utime{9'310'000});
  time.Observe(Utime{5'100'000}, Utime{9'320'000});
  EXPECT_EQ(*time.At(Utime{9'330'000}), Utime{5'200'000}) << "never goes back";
}

TEST(RobotPose, TheStartPoseTiesTheWorldToTheMap) {
  Pose pose;
  pose.T_WB = SE3(ExpSO3({0, 0, 0.5}), {1, 0, 0.02});
  pose.cov_T_WB.diagonal() << 0.01, 0.04, 1, 1, 1, 0.09;
  pose.cov_T_WB(0, 1) = pose.cov_T_WB(1, 0) = 0.01;
  const RobotPose on_map = OnMap(MapFromWorld({{2, 3}, 1.5707963267948966}), pose);
  EXPECT_LT((on_map.position - Eigen::Vector2d(2, 4)).norm(), 1e-9);
  EXPECT_NEAR(on_map.yaw, 2.0707963267948966, 1e-9);
  EXPECT_NEAR(on_map.sigma_m, std::sqrt(0.025 + std::hypot(0.015, 0.01)), 1e-9);
  EXPECT_NEAR(on_map.sigma_rad, 0.3, 1e-9);
}

}  // namespace
}  // namespace gw::navigate

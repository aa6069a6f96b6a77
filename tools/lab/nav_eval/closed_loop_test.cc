#include "tools/lab/nav_eval/closed_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tools/robot/navigate/robot_pose.h"
#include "tools/robot/navigate/run_record.h"

namespace gw::navigate {
namespace {

using ::testing::HasSubstr;

Utime Second(double s) {
  return UtimeFromSeconds(s);
}

eval::TimedPose At(double t, double x, double y, double yaw = 0) {
  return {Second(t), MapFromWorld({{x, y}, yaw})};
}

// Twice along x from 0 to 1 at 0.1 m/s; truly 3 cm to the left of the way.
TourRecord TwoVisits() {
  TourRecord record;
  for (int i = 0; i <= 200; ++i) record.poses.push_back(At(0.1 * i, 0.01 * (i % 101), 0));
  floorplan::Leg leg;
  for (int i = 0; i <= 20; ++i) leg.push_back({0.05 * i, 0});
  record.legs[0] = record.legs[1] = {leg};
  record.stops = {{Second(10), 0, 7, true, {{1, 0}, 0}}, {Second(20), 1, 7, true, {{1, 0}, 0}}};
  return record;
}

eval::Trajectory Truth(const TourRecord& record) {
  eval::Trajectory truth = record.poses;
  for (auto& pose : truth) pose.T = MapFromWorld({{0, 0.03}, 0}) * pose.T;
  return truth;
}

TEST(ClosedLoop, EstimateAndWayAreMeasuredAgainstTheTruth) {
  const TourRecord record = TwoVisits();
  const auto r = Evaluate(record, Truth(record));
  ASSERT_TRUE(r.ok());
  EXPECT_NEAR(r->est_rmse_m, 0.03, 1e-9);
  EXPECT_NEAR(r->nav_rmse_m, 0.03, 1e-9);
  EXPECT_EQ(r->reached, 2);
  EXPECT_NEAR(r->accuracy_m, 0.03, 0.001);
}

TEST(ClosedLoop, PrecisionIsTheSpreadOfTheTrueStopsNotTheirOffset) {
  const TourRecord record = TwoVisits();
  eval::Trajectory truth = Truth(record);
  for (auto& pose : truth) {
    const double dy = pose.utime < Second(15) ? 0.2 : 0.26;
    const double turn = pose.utime < Second(15) ? 0.1 : 0.14;
    pose.T = MapFromWorld({{0, dy}, 0}) * pose.T * MapFromWorld({{0, 0}, turn});
  }
  const auto r = Evaluate(record, truth);
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(r->precision_waypoints, 1);
  EXPECT_NEAR(r->precision_m, 0.03, 0.001);
  EXPECT_NEAR(r->precision_rad, 0.02, 1e-6);
  EXPECT_NEAR(r->accuracy_m, 0.26, 0.001);
}

TEST(ClosedLoop, AStopThatWasNotReachedCountsAsPlannedOnly) {
  TourRecord record = TwoVisits();
  record.stops[1].reached = false;
  const auto r = Evaluate(record, Truth(record));
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(r->stops, 2);
  EXPECT_EQ(r->reached, 1);
  EXPECT_EQ(r->precision_waypoints, 0);
  for (auto& pose : record.poses) pose.utime = pose.utime + Milliseconds(1'000'000);
  EXPECT_FALSE(Evaluate(record, Truth(TwoVisits())).ok());
}

TEST(ClosedLoop, ReadsWhatTheNavigatorWrites) {
  const std::string folder = ::testing::TempDir() + "/tour_record";
  {
    auto record = RunRecord::Create(folder);
    ASSERT_TRUE(record.ok());
    record->AddLeg(0, {{0, 0}, {0.05, 0}, {0.1, 0}});
    record->AddLeg(0, {{0.5, 0.5}, {0.45, 0.5}});
    record->AddPose({Second(3), {1, 2}, 0.5, 0.01, 0});
    record->AddStop({EventKind::kReached, 0, {Second(4), {1.01, 2}, 0.5, 0.01, 0}, ""}, 7,
                    {{1, 2}, 0.45});
    record->AddStop({EventKind::kUnreachable, 1, {}, "blocked"}, 8, {{3, 4}, 0});
    ASSERT_TRUE(record->Close().ok());
  }
  const auto read = ReadTourRecord(folder);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->stops.size(), 2u);
  EXPECT_EQ(read->stops[0].waypoint, 7);
  EXPECT_TRUE(read->stops[0].reached);
  EXPECT_FALSE(read->stops[1].reached);
  EXPECT_NEAR(read->stops[0].place.yaw, 0.45, 1e-9);
  ASSERT_EQ(read->legs.at(0).size(), 2u) << "the second way to the stop";
  EXPECT_EQ(read->legs.at(0)[1].size(), 2u);
  ASSERT_EQ(read->poses.size(), 1u);
  EXPECT_EQ(read->poses[0].utime, Second(3));

  std::ofstream(folder + "/stops.csv") << "utime,stop\n1,2,x\n";
  EXPECT_THAT(ReadTourRecord(folder).error().message, HasSubstr("stops.csv:2"));
  std::filesystem::remove_all(folder);
  EXPECT_EQ(ReadTourRecord(folder).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace gw::navigate

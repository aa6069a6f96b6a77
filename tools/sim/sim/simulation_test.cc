#include "tools/sim/sim/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/hash.h"
#include "common/wire/channels.h"
#include "tools/robot/floorplan/test_room.h"

namespace gw::sim {
namespace {

using ::testing::HasSubstr;

Scenario ShortDrive() {
  Scenario s;
  s.name = "test";
  s.waypoints = {{{1.2, 2.5}, 0}, {{4.6, 2.6}, 1.5}};
  s.max_duration_s = 2.5;
  s.rest_s = 0.3;
  s.pinhole = {160, 120, 96, 96, 80, 60};
  return s;
}

// All messages as one text, for comparison.
std::string RunToBytes(const Scenario& scenario, int threads, bool take_at_the_end) {
  auto sim = Simulation::Create(scenario, floorplan::RoomForTest(), Drive::kPath, Utime{1'000'000},
                                threads);
  EXPECT_TRUE(sim.ok());
  std::string bytes;
  const auto add = [&bytes](const std::vector<Outgoing>& messages) {
    for (const Outgoing& out : messages) {
      bytes += std::string(out.channel) + std::to_string(out.arrival.us);
      bytes.append(out.message.begin(), out.message.end());
    }
  };
  while ((*sim)->Step()) {
    if (!take_at_the_end) add((*sim)->Take());
  }
  add((*sim)->Take(true));
  return bytes;
}

TEST(Simulation, SameSeedGivesTheSameBytesForAnyPaceAndNumberOfThreads) {
  for (const CameraMode mode : {CameraMode::kStereo, CameraMode::kRgbd}) {
    Scenario s = ShortDrive();
    s.camera = mode;
    const std::string once = RunToBytes(s, 1, false);
    EXPECT_EQ(Fnv1a(once), Fnv1a(RunToBytes(s, 2, true)));
    EXPECT_EQ(Fnv1a(once), Fnv1a(RunToBytes(s, 3, false)));
    s.seed = 2;
    EXPECT_NE(Fnv1a(once), Fnv1a(RunToBytes(s, 1, false)));
  }
}

TEST(Simulation, EverySensorKeepsItsRateAndEveryImageHasItsTruth) {
  auto sim =
      Simulation::Create(ShortDrive(), floorplan::RoomForTest(), Drive::kPath, Utime{1'000'000}, 1);
  ASSERT_TRUE(sim.ok()) << sim.error().message;
  std::map<std::string, int> count;
  std::vector<int64_t> truth_times, image_times;
  int64_t last_arrival = 0;
  while ((*sim)->Step()) {
    for (const Outgoing& out : (*sim)->Take()) {
      EXPECT_GE(out.arrival.us, last_arrival);
      last_arrival = out.arrival.us;
      ++count[std::string(out.channel)];
      const auto header = wire::ReadHeader(out.message);
      ASSERT_TRUE(header.has_value());
      if (out.channel == wire::kGroundTruth) truth_times.push_back(header->utime.us);
      if (out.channel == wire::kCamera) {
        image_times.push_back(header->utime.us);
        EXPECT_TRUE(wire::DecodeCamera(out.message).ok());
      }
      if (out.channel == wire::kImu) {
        EXPECT_TRUE(wire::Decode<ImuSample>(out.message).ok());
      }
      if (out.channel == wire::kWheel) {
        EXPECT_TRUE(wire::Decode<WheelSample>(out.message).ok());
      }
    }
  }
  EXPECT_NEAR(count["IMU"], 500, 2);
  EXPECT_NEAR(count["WHEEL"], 49, 2);
  EXPECT_NEAR(count["CAMERA"], 74, 1);
  EXPECT_TRUE(std::is_sorted(truth_times.begin(), truth_times.end()));
  for (const int64_t t : image_times) {
    EXPECT_TRUE(std::binary_search(truth_times.begin(), truth_times.end(), t));
  }
}

TEST(Simulation, AStopInAWallIsAnErrorThatNamesIt) {
  Scenario s = ShortDrive();
  s.waypoints[1].position = {2.85, 2.5};
  const auto in_pillar = Simulation::Create(s, floorplan::RoomForTest(), Drive::kPath, Utime{0}, 1);
  ASSERT_FALSE(in_pillar.ok());
  EXPECT_THAT(in_pillar.error().message, HasSubstr("stop 1 at (2.85, 2.5)"));
  s.waypoints[1].position = {20, 2};
  EXPECT_FALSE(Simulation::Create(s, floorplan::RoomForTest(), Drive::kPath, Utime{0}, 1).ok());
  s.waypoints.clear();
  EXPECT_FALSE(Simulation::Create(s, floorplan::RoomForTest(), Drive::kPath, Utime{0}, 1).ok());
}

}  // namespace
}  // namespace gw::sim

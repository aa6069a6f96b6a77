#include "tools/sim/sim/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tools/robot/floorplan/floor_map.h"

namespace gw::sim {
namespace {

using ::testing::HasSubstr;

std::string MessageOf(const std::string& text) {
  const auto scenario = ParseScenario(text, "S.yaml");
  if (scenario.ok()) return "";
  EXPECT_EQ(scenario.error().code, ErrorCode::kBadConfig);
  return scenario.error().message;
}

TEST(Scenario, EveryShippedScenarioLoadsAndItsWaypointsCanBeDriven) {
  int count = 0;
  const std::filesystem::path folder = std::string(GW_SOURCE_DIR) + "/config/scenarios";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    ++count;
    const auto scenario = LoadScenario(entry.path().string());
    ASSERT_TRUE(scenario.ok()) << scenario.error().message;
    EXPECT_EQ(scenario->name, entry.path().stem().string());
    const auto map = floorplan::LoadFloorMap(scenario->map);
    ASSERT_TRUE(map.ok()) << map.error().message;
    std::vector<floorplan::Waypoint> stops;
    for (const int index : scenario->visit) stops.push_back(scenario->waypoints[index]);
    const auto legs = floorplan::PlanLegs(*map, stops, scenario->base.radius_m + 0.06);
    EXPECT_TRUE(legs.ok()) << entry.path() << ": " << legs.error().message;
  }
  EXPECT_GE(count, 1);
}

TEST(Scenario, AllMistakesAreReportedWithTheirLines) {
  const std::string message = MessageOf(
      "name: x\n"
      "speeed: 3\n"
      "laps: many\n"
      "camera: {width: 0, mode: sonar}\n"
      "world:\n"
      "  walls: textured\n"
      "  walls: blank\n"
      "  blank_regions: [[2, 0, 1, 1]]\n"
      "  boxes: [[2, 0, 1, 1, 0, 1]]\n"
      "events:\n"
      "  - {kind: lights_off, at_s: 3}\n"
      "  - {kind: slip, at_s: 3, for_s: 1, level: 0}\n");
  EXPECT_THAT(message, HasSubstr("S.yaml:2: speeed: no such key"));
  EXPECT_THAT(message, HasSubstr("S.yaml:3: laps: must be a whole number"));
  EXPECT_THAT(message, HasSubstr("S.yaml:4: camera.width: must be a whole number from 64"));
  EXPECT_THAT(message, HasSubstr("S.yaml:4: camera.mode: must be one of stereo, rgbd"));
  EXPECT_THAT(message, HasSubstr("S.yaml:7: world.walls: duplicate key"));
  EXPECT_THAT(message, HasSubstr("S.yaml:8: world.blank_regions[0]"));
  EXPECT_THAT(message, HasSubstr("S.yaml:9: world.boxes[0]: depth, width and height"));
  EXPECT_THAT(message, HasSubstr("S.yaml:11: events[0].for_s: missing"));
  EXPECT_THAT(message, HasSubstr("S.yaml:12: events[1].level: no such key"));
}

TEST(Scenario, NotYamlIsAnErrorWithALine) {
  EXPECT_THAT(MessageOf("name: [x\nmap: y"), HasSubstr("S.yaml:"));
  EXPECT_THAT(MessageOf(""), HasSubstr("S.yaml:1: file: must be"));
}

TEST(Scenario, AWaypointThatDoesNotExistCannotBeVisited) {
  EXPECT_THAT(MessageOf("name: x\nwaypoints: [[0, 0, 0]]\nvisit: [0, 1]\n"),
              HasSubstr("there is no waypoint 1"));
}

}  // namespace
}  // namespace gw::sim

#include "tools/sim/sim/hard_way.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace gw::sim {
namespace {

// 100 m along x at 0.5 m/s.
RecordedMotion Straight() {
  const std::string path =
      (std::filesystem::path(::testing::TempDir()) / "hard_way_straight.txt").string();
  {
    std::ofstream file(path);
    for (int i = 0; i <= 2000; ++i) file << 0.1 * i << " " << 0.05 * i << " 0 0 0 0 0 1\n";
  }
  auto motion = RecordedMotion::Load(path, path);
  std::filesystem::remove(path);
  return std::move(motion).value();
}

Scenario Asking(double length_m) {
  Scenario scenario;
  scenario.recorded = {length_m, 40, 5, 8};
  return scenario;
}

TEST(HardWay, EveryFortyMetresHaveADarkAndABareSpan) {
  Scenario scenario = Asking(80);
  MakeWayHard(Straight(), &scenario);
  EXPECT_NEAR(scenario.max_duration_s, 160, 0.2);
  ASSERT_EQ(scenario.events.size(), 2U);
  ASSERT_EQ(scenario.world.blank_regions.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const Event& dark = scenario.events[i];
    EXPECT_EQ(dark.kind, EventKind::kLightsOff);
    EXPECT_NEAR(dark.at_s, (i + 1.0 / 3) * 80, 0.3);
    EXPECT_EQ(dark.for_s, 5);
    const Region& bare = scenario.world.blank_regions[i];
    EXPECT_TRUE(bare.Contains({(i + 0.76) * 40, 1.6}));
    EXPECT_FALSE(bare.Contains({(i + 0.5) * 40, 0}));
    EXPECT_FALSE(bare.Contains({(i + 0.95) * 40, 0}));
  }
}

TEST(HardWay, AShortWayHasOneOfEach) {
  Scenario scenario = Asking(10);
  MakeWayHard(Straight(), &scenario);
  EXPECT_EQ(scenario.events.size(), 1U);
  EXPECT_EQ(scenario.world.blank_regions.size(), 1U);
  EXPECT_LT(scenario.events[0].at_s, scenario.max_duration_s);
}

TEST(HardWay, NothingIsHardUnlessAskedFor) {
  Scenario scenario;
  MakeWayHard(Straight(), &scenario);
  EXPECT_TRUE(scenario.events.empty());
  EXPECT_TRUE(scenario.world.blank_regions.empty());
  EXPECT_NEAR(scenario.max_duration_s, 200, 0.2);
}

}  // namespace
}  // namespace gw::sim

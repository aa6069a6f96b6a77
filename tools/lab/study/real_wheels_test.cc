#include "tools/lab/study/real_wheels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace gw::study {
namespace {

using ::testing::HasSubstr;

// 100 m along x at 0.5 m/s.
sim::RecordedMotion Straight() {
  const std::string path =
      (std::filesystem::path(::testing::TempDir()) / "real_wheels_straight.txt").string();
  {
    std::ofstream file(path);
    for (int i = 0; i <= 2000; ++i) file << 0.1 * i << " " << 0.05 * i << " 0 0 0 0 0 1\n";
  }
  auto motion = sim::RecordedMotion::Load(path, path);
  std::filesystem::remove(path);
  return std::move(motion).value();
}

TEST(RealWheels, EveryFortyMetresHaveADarkAndABareSpan) {
  const sim::RecordedMotion motion = Straight();
  sim::Scenario scenario;
  MakeWayHard(motion, 80, &scenario);
  EXPECT_NEAR(scenario.max_duration_s, 160, 0.2);
  ASSERT_EQ(scenario.events.size(), 2U);
  ASSERT_EQ(scenario.world.blank_regions.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const sim::Event& dark = scenario.events[i];
    EXPECT_EQ(dark.kind, sim::EventKind::kLightsOff);
    EXPECT_NEAR(dark.at_s, (i + 1.0 / 3) * 80, 0.3);
    EXPECT_EQ(dark.for_s, 5);
    const sim::Region& bare = scenario.world.blank_regions[i];
    EXPECT_TRUE(bare.Contains({(i + 0.76) * 40, 1.6}));
    EXPECT_FALSE(bare.Contains({(i + 0.5) * 40, 0}));
    EXPECT_FALSE(bare.Contains({(i + 0.95) * 40, 0}));
  }
}

TEST(RealWheels, AShortWayHasOneOfEach) {
  sim::Scenario scenario;
  MakeWayHard(Straight(), 10, &scenario);
  EXPECT_EQ(scenario.events.size(), 1U);
  EXPECT_EQ(scenario.world.blank_regions.size(), 1U);
  EXPECT_LT(scenario.events[0].at_s, scenario.max_duration_s);
}

RealWheelsRow Row(double wheels, double none, double full) {
  RealWheelsRow row;
  row.name = "r";
  row.wheels_m = wheels;
  row.none.ape_m = none;
  row.full.ape_m = full;
  return row;
}

TEST(RealWheels, TheBarIsTheBetterWitness) {
  EXPECT_NEAR(*RatiosOf(Row(1, 4, 0.5)).to_best, 0.5, 1e-9);
  EXPECT_NEAR(*RatiosOf(Row(4, 1, 0.5)).to_best, 0.5, 1e-9);
  EXPECT_NEAR(*RatiosOf(Row(4, 1, 0.5)).to_wheels, 0.125, 1e-9);
  // Vision that is lost from the begin leaves the wheels.
  RealWheelsRow lost = Row(2, 0, 1);
  lost.none.ape_m.reset();
  EXPECT_NEAR(*RatiosOf(lost).to_best, 0.5, 1e-9);
  EXPECT_THAT(RenderRealWheels("o", {Row(1, 4, 0.4)}).markdown, HasSubstr("0.40 | met |"));
  EXPECT_THAT(RenderRealWheels("o", {Row(1, 4, 0.4)}).markdown, HasSubstr("mean: 0.40, met"));
  // Better than wheels that are as good as vision, but not by half in the mean.
  EXPECT_THAT(RenderRealWheels("o", {Row(1, 4, 1.04), Row(1, 4, 0.2)}).markdown,
              HasSubstr("mean: 0.62, **missed**"));
  RealWheelsRow without_pose = Row(1, 4, 0.4);
  without_pose.full.without_pose = 1;
  EXPECT_THAT(RenderRealWheels("o", {without_pose}).markdown, HasSubstr("0.40 | **missed** |"));
}

}  // namespace
}  // namespace gw::study

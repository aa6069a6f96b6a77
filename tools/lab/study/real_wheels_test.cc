#include "tools/lab/study/real_wheels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gw::study {
namespace {

using ::testing::HasSubstr;

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

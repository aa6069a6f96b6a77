#include "frontend/core/motion/dr_disagreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Windows of a robot that drives about; dead reckoning sees them with a way that is multiplied and
// turned, and a turn that is multiplied; vision is off by a centimetre.
DrConstantFault Drive(double way, double direction, double turn, int windows = 12) {
  DrDisagreement disagreement;
  CounterRng rng(5, 1, 0);
  for (int i = 0; i < windows; ++i) {
    const double yaw = rng.Uniform(-0.8, 0.8);
    const Eigen::Vector3d t(rng.Uniform(0.3, 0.6), 0, 0);
    const Eigen::Vector3d t_dr = way * (ExpSO3({0, 0, direction}) * t);
    const Eigen::Vector3d noise(0.01 * rng.Normal(), 0.01 * rng.Normal(), 0);
    disagreement.Add(SE3(ExpSO3({0, 0, turn * yaw}), t_dr), SE3(ExpSO3({0, 0, yaw}), t + noise));
  }
  return disagreement.Explain();
}

TEST(DrDisagreement, TellsTheConstant) {
  const DrConstantFault twice = Drive(2, 0, 1);
  ASSERT_TRUE(twice.way_factor);
  EXPECT_NEAR(*twice.way_factor, 0.5, 0.01);
  EXPECT_FALSE(twice.direction);
  EXPECT_FALSE(twice.turn_factor);
  EXPECT_THAT(Describe(twice), HasSubstr("multiply ticks_per_metre by"));

  const DrConstantFault millimetres = Drive(1000, 0, 1);
  ASSERT_TRUE(millimetres.way_factor);
  EXPECT_NEAR(*millimetres.way_factor, 0.001, 1e-5);

  const DrConstantFault turned = Drive(1, M_PI / 2, 1);
  ASSERT_TRUE(turned.direction);
  EXPECT_NEAR(*turned.direction, -M_PI / 2, 0.02);
  EXPECT_FALSE(turned.way_factor);
  EXPECT_THAT(Describe(turned), HasSubstr("axes"));

  const DrConstantFault reversed = Drive(1, M_PI, -1);
  EXPECT_THAT(Describe(reversed), HasSubstr("backwards"));
  ASSERT_TRUE(reversed.turn_factor);
  EXPECT_NEAR(*reversed.turn_factor, -1, 0.01);
  EXPECT_THAT(Describe(reversed), HasSubstr("the other way"));
}

TEST(DrDisagreement, SaysNothingOfSoundDeadReckoningNorOfTooLittle) {
  EXPECT_THAT(Describe(Drive(1, 0, 1)), IsEmpty());
  EXPECT_THAT(Describe(Drive(2, 0, 1, 1)), IsEmpty());
}

// A slip, a stuck heading: no constant.
TEST(DrDisagreement, SaysNothingWhereNoConstantExplains) {
  DrDisagreement stuck;
  CounterRng rng(5, 2, 0);
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d t(0.4, 0, 0);
    const double way = i % 3 == 0 ? 5 : 0.1;
    stuck.Add(SE3(Eigen::Quaterniond::Identity(), way * t),
              SE3(ExpSO3({0, 0, rng.Uniform(-1, 1)}), t));
  }
  EXPECT_THAT(Describe(stuck.Explain()), IsEmpty());
}

}  // namespace
}  // namespace gw::frontend

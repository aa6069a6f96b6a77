#include "frontend/core/motion/dr_disagreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// The constant that explains a window or more, and what is then wrong.
DrConstantFault FaultIn(const DrDisagreement& disagreement) {
  const DrExplanation e = disagreement.Explain();
  const auto way = e.way.value_or(1);
  return FaultOf(std::abs(way), std::arg(way), e.turn.value_or(1));
}

// Windows of a robot that drives about; dead reckoning sees them with a way that is multiplied and
// turned, and a turn that is multiplied; vision is off by a centimetre, and says so.
class Drive {
 public:
  void Add(double way, double direction, double turn) {
    const double yaw = rng_.Uniform(-0.8, 0.8);
    Vector6d steps, told;
    steps << rng_.Uniform(0.3, 0.6), 0, 0, 0, 0, yaw;
    told << way * (ExpSO3({0, 0, direction}) * steps.head<3>()), 0, 0, turn * yaw;
    steps.head<2>() += 0.01 * Eigen::Vector2d(rng_.Normal(), rng_.Normal());
    DrEvidence evidence;
    evidence.T_dr = SE3::Exp(told);
    evidence.T_vision = SE3::Exp(steps);
    evidence.cov_dr = evidence.cov_vision = 1e-4 * Matrix6d::Identity();
    evidence.cov_dr *= way * way;
    disagreement_.Add(evidence);
  }
  DrConstantFault fault() const { return FaultIn(disagreement_); }

 private:
  DrDisagreement disagreement_;
  CounterRng rng_{5, 1, 0};
};

DrConstantFault DriveWith(double way, double direction, double turn, int windows = 12) {
  Drive drive;
  for (int i = 0; i < windows; ++i) drive.Add(way, direction, turn);
  return drive.fault();
}

TEST(DrDisagreement, TellsTheConstant) {
  const DrConstantFault twice = DriveWith(2, 0, 1);
  ASSERT_TRUE(twice.way_factor);
  EXPECT_NEAR(*twice.way_factor, 0.5, 0.01);
  EXPECT_FALSE(twice.direction);
  EXPECT_FALSE(twice.turn_factor);
  EXPECT_THAT(Describe(twice), HasSubstr("multiply ticks_per_metre by"));

  const DrConstantFault millimetres = DriveWith(1000, 0, 1);
  ASSERT_TRUE(millimetres.way_factor);
  EXPECT_NEAR(*millimetres.way_factor, 0.001, 1e-5);

  const DrConstantFault turned = DriveWith(1, M_PI / 2, 1);
  ASSERT_TRUE(turned.direction);
  EXPECT_NEAR(*turned.direction, -M_PI / 2, 0.02);
  EXPECT_FALSE(turned.way_factor);
  EXPECT_THAT(Describe(turned), HasSubstr("axes"));

  const DrConstantFault reversed = DriveWith(1, M_PI, -1);
  EXPECT_THAT(Describe(reversed), HasSubstr("backwards"));
  ASSERT_TRUE(reversed.turn_factor);
  EXPECT_NEAR(*reversed.turn_factor, -1, 0.01);
  EXPECT_THAT(Describe(reversed), HasSubstr("the other way"));
}

TEST(DrDisagreement, SaysNothingOfSoundDeadReckoningNorOfTooLittle) {
  EXPECT_THAT(Describe(DriveWith(1, 0, 1)), IsEmpty());
  EXPECT_THAT(Describe(DriveWith(2, 0, 1, 1)), IsEmpty());
}

// A filter that changes its mind: its way shrinks from window to window, by a tenth of it. The
// squares that the best constant leaves are few, and yet there is none.
TEST(DrDisagreement, SaysNothingWhereTheFactorWanders) {
  Drive drive;
  double way = 0.8;
  for (int i = 0; i < 6; ++i) drive.Add(way *= 0.9, M_PI / 2, 1);
  EXPECT_THAT(Describe(drive.fault()), IsEmpty());
}

// The first window has a factor and a direction whatever is wrong; the second does not follow it.
TEST(DrDisagreement, IsNotToldByOneWindow) {
  Drive drive;
  drive.Add(2, 0.3, 1);
  drive.Add(1, -0.5, 1);
  EXPECT_THAT(Describe(drive.fault()), IsEmpty());
}

// A slip, a stuck heading: no constant.
TEST(DrDisagreement, SaysNothingWhereNoConstantExplains) {
  DrDisagreement stuck;
  CounterRng rng(5, 2, 0);
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d t(0.4, 0, 0);
    const double way = i % 3 == 0 ? 5 : 0.1;
    DrEvidence evidence;
    evidence.T_dr = SE3(Eigen::Quaterniond::Identity(), way * t);
    evidence.T_vision = SE3(ExpSO3({0, 0, rng.Uniform(-1, 1)}), t);
    evidence.cov_dr = evidence.cov_vision = 1e-4 * Matrix6d::Identity();
    stuck.Add(evidence);
  }
  EXPECT_THAT(Describe(FaultIn(stuck)), IsEmpty());
}

}  // namespace
}  // namespace gw::frontend

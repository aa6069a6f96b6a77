#include "frontend/core/motion/dr_constant.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

SE3 Motion(double x, double y, double yaw) {
  return SE3(ExpSO3({0, 0, yaw}), {x, y, 0});
}

// A circle in small steps, and what wheels tell of it that are wrong by a constant.
struct Drive {
  DrState truth, told, corrected;
  void Go(const DrConstant& constant, double way_told, double direction_told, double turn_told) {
    const double way = 0.005, turn = 0.01;
    truth.T_OB = truth.T_OB * Motion(way, 0, turn);
    DrState next = told;
    next.T_OB = told.T_OB * Motion(way_told * way * std::cos(direction_told),
                                   way_told * way * std::sin(direction_told), turn_told * turn);
    next.v_OB_B = way_told * Eigen::Vector3d(std::cos(direction_told), std::sin(direction_told), 0);
    next.w_OB_B = {0, 0, turn_told};
    next.cov_twist_white = Matrix6d::Identity() * 1e-6;
    corrected = constant.Follow(corrected, told, next);
    told = next;
  }
};

TEST(DrConstant, TakenOutLeavesTheTrueMotion) {
  struct Fault {
    double way, direction, turn;
  };
  for (const auto& [way, direction, turn] :
       {Fault{2, 0, 1}, Fault{0.5, 0, 1}, Fault{1, M_PI, 1}, Fault{1, M_PI / 2, 1},
        Fault{1000, 0, 1}, Fault{1, 0, -1}, Fault{2, -0.3, 0.5}}) {
    DrConstant constant;
    constant.Take({std::polar(1 / way, -direction), 1 / turn});
    Drive drive;
    for (int i = 0; i < 400; ++i) drive.Go(constant, way, direction, turn);
    const SE3 apart = drive.truth.T_OB.inverse() * drive.corrected.T_OB;
    EXPECT_LT(apart.Log().norm(), 1e-9) << way << " " << direction << " " << turn;
    EXPECT_LT((drive.corrected.v_OB_B - Eigen::Vector3d::UnitX()).norm(), 1e-9);
    EXPECT_NEAR(drive.corrected.w_OB_B.z(), 1, 1e-9);
    EXPECT_NEAR(drive.corrected.cov_twist_white(0, 0), 1e-6 / (way * way), 1e-12);
  }
}

TEST(DrConstant, TakesOverWhatIsExplained) {
  DrConstant constant;
  EXPECT_TRUE(constant.fault().empty());
  constant.Take({std::polar(2.0, 3.0), -1});
  EXPECT_NEAR(*constant.fault().way_factor, 2, 1e-12);
  EXPECT_NEAR(*constant.fault().direction, 3, 1e-12);
  EXPECT_NEAR(*constant.fault().turn_factor, -1, 1e-12);
  // What is not explained stays; what is as it should be is no constant.
  const DrConstant before = constant;
  constant.Take({std::polar(1.01, 0.0), std::nullopt});
  EXPECT_FALSE(constant.fault().way_factor);
  EXPECT_FALSE(constant.fault().direction);
  EXPECT_NEAR(*constant.fault().turn_factor, -1, 1e-12);
  EXPECT_FALSE(constant.Beside(before).turn_factor);
  EXPECT_NEAR(*constant.Beside(before).way_factor, 0.5, 1e-12);
}

}  // namespace
}  // namespace gw::frontend

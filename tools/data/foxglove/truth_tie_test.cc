#include "tools/data/foxglove/truth_tie.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gw::foxglove {
namespace {

SE3 Planar(double x, double y, double yaw) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {x, y, 0}};
}

TEST(TruthTie, FindsTheFrameFromTheFirstPose) {
  const SE3 T_WG = Planar(3, -2, 2.5);
  const SE3 T_GB = Planar(1, 4, 0.3);
  TruthTie tie;
  tie.Add(T_WG * T_GB, T_GB);
  EXPECT_LT((tie.T_WG().inverse() * T_WG).Log().norm(), 1e-12);
}

TEST(TruthTie, ALongWayOverrulesAHeadingThatIsOff) {
  const SE3 T_WG = Planar(3, -2, 2.5);
  TruthTie tie;
  for (int i = 0; i < 500; ++i) {
    const SE3 T_GB = Planar(0.1 * i, std::sin(0.1 * i), 0);
    const SE3 T_WB = T_WG * T_GB;
    tie.Add(SE3(T_WB.rotation() * Planar(0, 0, 0.1).rotation(), T_WB.translation()), T_GB);
  }
  const double yaw = YawOf((tie.T_WG().inverse() * T_WG).rotation());
  EXPECT_LT(std::abs(yaw), 0.002);
}

}  // namespace
}  // namespace gw::foxglove

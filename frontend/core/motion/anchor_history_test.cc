#include "frontend/core/motion/anchor_history.h"

#include <gtest/gtest.h>

namespace gw::frontend {
namespace {

SE3 At(double x) {
  return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0)};
}

Utime Second(double t) {
  return Utime{static_cast<int64_t>(t * 1e6)};
}

TEST(AnchorHistory, GivesTheFirstImageNotBeforeATime) {
  AnchorHistory history;
  EXPECT_FALSE(history.From(Second(1)));
  history.Remember(Second(1), At(1), Matrix6d::Zero());
  history.Remember(Second(2), At(2), Matrix6d::Zero());
  EXPECT_EQ(history.From(Second(0))->T_WO.translation().x(), 1);
  EXPECT_EQ(history.From(Second(1))->T_WO.translation().x(), 1);
  EXPECT_EQ(history.From(Second(1.5))->T_WO.translation().x(), 2);
  EXPECT_FALSE(history.From(Second(2.5)));
  EXPECT_EQ(history.From(Second(0))->num_images, 1);
}

TEST(AnchorHistory, GivesTheLastImageBeforeATime) {
  AnchorHistory history;
  EXPECT_FALSE(history.Before(Second(1)));
  history.Remember(Second(1), At(1), Matrix6d::Zero());
  history.Remember(Second(2), At(2), Matrix6d::Zero());
  EXPECT_EQ(history.Before(Second(0))->T_WO.translation().x(), 1);  // nothing older is known
  EXPECT_EQ(history.Before(Second(2))->T_WO.translation().x(), 1);
  EXPECT_EQ(history.Before(Second(2))->num_images, 1);
  EXPECT_FALSE(history.Before(Second(2.5)));
}

TEST(AnchorHistory, ForgetsWhatIsLongAgo) {
  AnchorHistory history;
  for (int t = 1; t <= 8; ++t) history.Remember(Second(t), At(t), Matrix6d::Zero());
  EXPECT_EQ(history.From(Second(0))->T_WO.translation().x(), 3);  // five seconds before the newest
}

TEST(AnchorHistory, FollowsTheMap) {
  AnchorHistory history;
  history.Remember(Second(1), At(1), Matrix6d::Zero());
  history.Move(At(10));
  EXPECT_EQ(history.From(Second(1))->T_WO.translation().x(), 11);
  history.Clear();
  EXPECT_FALSE(history.From(Second(1)));
}

}  // namespace
}  // namespace gw::frontend

#include "tools/lab/eval/spline.h"

#include <gtest/gtest.h>

#include "tools/lab/eval/test_trajectories.h"

namespace gw::eval {
namespace {

// Control poses of a random walk.
PoseSpline RandomSpline() {
  PoseSpline spline(UtimeFromSeconds(10), UtimeFromSeconds(12), Milliseconds(250));
  CounterRng rng(1, 0, 0);
  SE3 T = RandomPose(rng);
  for (SE3& control : spline.controls()) {
    Vector6d step;
    for (int i = 0; i < 6; ++i) step[i] = 0.4 * rng.Normal();
    T = T * SE3::Exp(step);
    control = T;
  }
  return spline;
}

TEST(PoseSpline, ConstantMotionIsMetExactly) {
  PoseSpline spline(UtimeFromSeconds(0), UtimeFromSeconds(3), Milliseconds(500));
  Vector6d twist;
  twist << 0.7, -0.2, 0.1, 0.3, -0.2, 0.9;
  for (size_t i = 0; i < spline.controls().size(); ++i) {
    spline.controls()[i] = SE3::Exp(spline.TimeOf(i).seconds() * twist);
  }
  for (const double t : {0.0, 0.123, 0.5, 1.49, 2.999, 3.0}) {
    const Utime at = UtimeFromSeconds(t);
    EXPECT_LT((SE3::Exp(t * twist).inverse() * spline.Pose(at)).Log().norm(), 1e-12) << t;
    EXPECT_LT((spline.Rate(at) - twist.tail<3>()).norm(), 1e-12) << t;
  }
}

// Worked out by hand: on a line the spline is the cubic B-spline of the positions.
TEST(PoseSpline, OnALineItIsTheBSplineOfThePositions) {
  PoseSpline spline(UtimeFromSeconds(0), UtimeFromSeconds(1), Milliseconds(1000));
  ASSERT_EQ(spline.controls().size(), 4u);
  spline.controls()[2] = SE3(Eigen::Quaterniond::Identity(), {1, 0, 0});
  EXPECT_NEAR(spline.Pose(UtimeFromSeconds(0.0)).translation().x(), 1.0 / 6, 1e-12);
  EXPECT_NEAR(spline.Pose(UtimeFromSeconds(0.5)).translation().x(), 23.0 / 48, 1e-12);
  EXPECT_NEAR(spline.Pose(UtimeFromSeconds(1.0)).translation().x(), 4.0 / 6, 1e-12);
}

TEST(PoseSpline, RateIsTheDerivativeOfTheRotation) {
  const PoseSpline spline = RandomSpline();
  const DurationUs h{200};
  for (double t = 10.05; t < 11.95; t += 0.11) {
    const Utime at = UtimeFromSeconds(t);
    const Eigen::Quaterniond before = spline.Pose(at - h).rotation();
    const Eigen::Quaterniond after = spline.Pose(at + h).rotation();
    const Eigen::Vector3d numeric = LogSO3(before.conjugate() * after) / (2 * h.seconds());
    EXPECT_LT((spline.Rate(at) - numeric).norm(), 1e-5) << t;
  }
}

TEST(PoseSpline, KnotsAreNotSeen) {
  const PoseSpline spline = RandomSpline();
  for (const double t : {10.25, 10.5, 11.75}) {
    const Utime knot = UtimeFromSeconds(t);
    const SE3 step = spline.Pose(knot - DurationUs{1}).inverse() * spline.Pose(knot);
    EXPECT_LT(step.Log().norm(), 2e-5);
    EXPECT_LT((spline.Rate(knot - DurationUs{1}) - spline.Rate(knot)).norm(), 2e-4);
  }
}

}  // namespace
}  // namespace gw::eval

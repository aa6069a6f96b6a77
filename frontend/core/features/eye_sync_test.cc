#include "frontend/core/features/eye_sync.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

constexpr DurationUs kPeriod = Milliseconds(33);

RectifiedCamera Camera() {
  return TestCamera(10);
}

// Row offsets of an image whose right eye is late, of a camera that moves by T_ab in a period. A
// tenth of the partners is wrong; rectification leaves `askew` px at the edges.
FeatureFrame See(const SE3& T_ab, double lateness_s, double askew, uint64_t image) {
  const RectifiedCamera camera = Camera();
  FeatureFrame frame;
  CounterRng rng(3, 1, image);
  const SE3 T_late = SE3::Exp(T_ab.Log() * (lateness_s / kPeriod.seconds()));
  for (int i = 0; i < 150; ++i) {
    Feature f;
    f.u = static_cast<float>(rng.Uniform(5, 635));
    f.v = static_cast<float>(rng.Uniform(5, 475));
    f.depth = static_cast<float>(rng.Uniform(1, 6));
    const Eigen::Vector3d p = T_late.inverse() * camera.Unproject(f.u, f.v, f.depth);
    double dv = camera.Project(p).y() - f.v + 0.5 * rng.Normal() + askew * (f.v - 240) / 240;
    if (i % 10 == 0) dv = rng.Uniform(-8, 8);
    frame.features.push_back(f);
    frame.row_offsets.push_back({i, static_cast<float>(dv)});
  }
  return frame;
}

const SE3 kForward(Eigen::Quaterniond::Identity(), {0, 0, 0.02});  // 0.6 m/s
const SE3 kTurn(ExpSO3({0, 0.02, 0}), {0.004, 0, 0.01});           // 0.6 rad/s
const SE3 kStill;

struct Outcome {
  double lateness_s;
  int spoilt;
};
Outcome Drive(double lateness_s, double askew) {
  EyeSync sync(Camera());
  int spoilt = 0;
  for (uint64_t k = 0; k < 120; ++k) {
    const SE3& T_ab = k < 15 ? kStill : k % 60 < 40 ? kForward : kTurn;
    const FeatureFrame frame = See(T_ab, lateness_s, askew, k);
    sync.Observe(frame, T_ab, kPeriod);
    spoilt += sync.SpoilsDepth(frame, T_ab, kPeriod);
  }
  return {sync.Lateness(), spoilt};
}

TEST(EyeSync, FindsOutHowLateTheRightEyeIs) {
  for (const double late : {0.033, -0.033, 0.015}) {
    const Outcome found = Drive(late, 0);
    EXPECT_NEAR(found.lateness_s, late, 0.15 * std::abs(late));
    EXPECT_GE(found.spoilt, 40) << late;  // in the turns at least
  }
}

TEST(EyeSync, IsContentWithEyesOfOneInstant) {
  EXPECT_EQ(Drive(0, 0).spoilt, 0);
  EXPECT_EQ(Drive(0.0005, 0).spoilt, 0);
}

TEST(EyeSync, DoesNotTakeEyesThatAreAskewForLate) {
  EXPECT_EQ(Drive(0, 1.5).spoilt, 0);
  EXPECT_NEAR(Drive(0.033, 1.5).lateness_s, 0.033, 0.006);
}

TEST(EyeSync, LeavesDepthAloneWhileTheRobotStands) {
  EyeSync sync(Camera());
  for (uint64_t k = 0; k < 60; ++k) sync.Observe(See(kForward, 0.033, 0, k), kForward, kPeriod);
  EXPECT_TRUE(sync.SpoilsDepth(See(kForward, 0.033, 0, 61), kForward, kPeriod));
  EXPECT_FALSE(sync.SpoilsDepth(See(kStill, 0.033, 0, 61), kStill, kPeriod));
}

}  // namespace
}  // namespace gw::frontend

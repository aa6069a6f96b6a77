#include "frontend/core/place/view_change.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

RectifiedCamera Camera() {
  return TestCamera(6);
}

// A cloud of points before the camera, seen from T_OC: a third of them is found in an image, each
// bit of a descriptor is wrong with 5 %.
FeatureFrame See(uint64_t scene, const SE3& T_OC, uint64_t image, int num_points = 4000) {
  const RectifiedCamera camera = Camera();
  FeatureFrame frame;
  CounterRng points(scene, 1, 0);
  CounterRng chance(scene, 2, image);
  for (int i = 0; i < num_points; ++i) {
    const Eigen::Vector3d p_O(8 * points.Uniform() - 4, 5 * points.Uniform() - 2.5,
                              1.5 + 5 * points.Uniform());
    Descriptor descriptor;
    for (uint64_t& word : descriptor) word = points.NextU64();
    const Eigen::Vector3d p_C = T_OC.inverse() * p_O;
    const bool found = chance.Uniform() < 0.33;
    for (uint64_t& word : descriptor) {
      for (int bit = 0; bit < 64; ++bit) {
        if (chance.Uniform() < 0.05) word ^= uint64_t{1} << bit;
      }
    }
    if (p_C.z() < 0.3 || !found) continue;
    const Eigen::Vector2d uv = camera.Project(p_C);
    if (!camera.InImage(uv)) continue;
    Feature f;
    f.u = static_cast<float>(uv.x() + 0.7 * chance.Normal());
    f.v = static_cast<float>(uv.y() + 0.7 * chance.Normal());
    if (chance.Uniform() < 0.5) f.depth = static_cast<float>(p_C.z());
    frame.features.push_back(f);
    frame.descriptors.push_back(descriptor);
  }
  return frame;
}

const SE3 kStart;
const SE3 kTurned(ExpSO3({0, 0.15, 0}), {0.02, 0, 0.1});

class ViewChanges : public testing::Test {
 protected:
  ViewChanges() : view_(Camera()) { EXPECT_FALSE(Observe(See(1, kStart, 1), kStart)); }
  bool Observe(const FeatureFrame& frame, const std::optional<SE3>& T_OC) {
    const bool changed = view_.Changed(frame, T_OC);
    view_.Remember(frame, T_OC);
    return changed;
  }

 private:
  ViewChange view_;
};

TEST_F(ViewChanges, NotWhileTheRobotMovesThroughTheScene) {
  EXPECT_FALSE(Observe(See(1, kTurned, 2), kTurned));
}

TEST_F(ViewChanges, WhenTheRobotIsElsewhereAtOnce) {
  EXPECT_TRUE(Observe(See(2, kStart, 2), kTurned));
  // The new scene stays.
  EXPECT_FALSE(Observe(See(2, kStart, 3), kTurned));
}

TEST_F(ViewChanges, WhenTheImageTurnsWithoutTheWheels) {
  const SE3 turned(ExpSO3({0, 0.6, 0}), {0, 0, 0});
  EXPECT_TRUE(Observe(See(1, turned, 2), kStart));
}

TEST_F(ViewChanges, IsNotSaidOfPoorImages) {
  EXPECT_FALSE(Observe(See(2, kStart, 2, 400), kStart));
  // Nor of the first after them.
  EXPECT_FALSE(Observe(See(3, kStart, 3), kStart));
}

// As between images that a slow camera takes while the robot drives.
TEST_F(ViewChanges, AlsoAcrossAWayOnWhichTheViewStaysInSight) {
  const SE3 far(Eigen::Quaterniond::Identity(), {0, 0, 0.5});
  EXPECT_FALSE(Observe(See(1, far, 2), far));
  const SE3 farther(ExpSO3({0, 0.15, 0}), {0.1, 0, 0.9});
  EXPECT_TRUE(Observe(See(2, farther, 3), farther));
}

TEST_F(ViewChanges, IsNotSaidWhereTheImagesHaveLittleInCommon) {
  const SE3 turned(ExpSO3({0, 1.0, 0}), {0, 0, 0});
  EXPECT_FALSE(Observe(See(2, turned, 2), turned));
}

// Where they are in the image, their depth decides: they are not expected anywhere.
TEST_F(ViewChanges, FeaturesWithoutDepthSayNothingAcrossAWay) {
  FeatureFrame before = See(1, kStart, 1);
  for (Feature& f : before.features) f.depth = 0;
  const SE3 beside(Eigen::Quaterniond::Identity(), {0.6, 0, 0});
  EXPECT_EQ(CountSeenAgain(Camera(), before, See(1, beside, 2), beside.inverse()).expected, 0);
  EXPECT_GT(CountSeenAgain(Camera(), before, See(1, kStart, 2), SE3()).share(), 0.2);
}

TEST_F(ViewChanges, IsNotSaidWithoutDeadReckoning) {
  EXPECT_FALSE(Observe(See(2, kStart, 2), std::nullopt));
  EXPECT_FALSE(Observe(See(3, kStart, 3), kStart));
}

}  // namespace
}  // namespace gw::frontend

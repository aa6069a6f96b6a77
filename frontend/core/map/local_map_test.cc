#include "frontend/core/map/local_map.h"

#include <gtest/gtest.h>

#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

// A keyframe of one landmark, 4 m ahead.
Keyframe MakeKeyframe(int64_t id, double x) {
  Keyframe k;
  k.id = {id};
  k.utime = {id * 100000};
  k.T_WC = SE3(Eigen::Quaterniond::Identity(), {x, 0, 0});
  Feature f;
  f.u = 300;
  f.v = 200;
  f.depth = 4;
  k.features = {f};
  k.descriptors.resize(1);
  k.landmarks = {LandmarkId::From(k.id, 0)};
  return k;
}

// What the back-end makes of keyframes and their landmarks: all 1 cm higher.
MapUpdate UpdateOf(const std::vector<Keyframe>& keyframes, const LocalMap& map, int64_t revision) {
  MapUpdate out;
  out.base_revision = revision - 1;
  out.revision = revision;
  for (const Keyframe& k : keyframes) {
    out.newest_keyframe = k.id;
    out.keyframes.push_back(
        {k.id, k.utime, SE3(Eigen::Quaterniond::Identity(), {0, 0, 0.01}) * k.T_WC});
    LandmarkUpdate l;
    l.id = k.landmarks[0];
    l.p_W = map.Find(l.id)->p_W + Eigen::Vector3d(0, 0, 0.01);
    l.observations = {{k.id, 0}};
    out.landmarks.push_back(l);
  }
  return out;
}

TEST(LocalMap, LengthsAreScaledAroundTheFirstKeyframe) {
  LocalMap map(TestCamera(4), Pyramid(1.2, 8));
  EXPECT_FALSE(map.ScaleLengths(0.5));
  const Keyframe first = MakeKeyframe(1, 2), second = MakeKeyframe(2, 3);
  map.AddKeyframe(first);
  map.AddKeyframe(second);
  const MapPoint before = *map.Find(second.landmarks[0]);
  const auto center = map.ScaleLengths(0.5);
  ASSERT_TRUE(center);
  EXPECT_TRUE(center->isApprox(first.T_WC.translation()));
  EXPECT_TRUE(map.KeyframePose({1})->translation().isApprox(Eigen::Vector3d(2, 0, 0)));
  EXPECT_TRUE(map.KeyframePose({2})->translation().isApprox(Eigen::Vector3d(2.5, 0, 0)));
  const MapPoint& after = *map.Find(second.landmarks[0]);
  EXPECT_TRUE((after.p_W - *center).isApprox(0.5 * (before.p_W - *center)));
  EXPECT_FLOAT_EQ(after.max_distance, 0.5F * before.max_distance);
}

TEST(LocalMap, UpdatesInOtherLengthsDoNotMoveIt) {
  LocalMap map(TestCamera(4), Pyramid(1.2, 8));
  const Keyframe first = MakeKeyframe(1, 2), second = MakeKeyframe(2, 3);
  map.AddKeyframe(first);
  map.AddKeyframe(second);
  MapUpdate late = UpdateOf({first, second}, map, 1);
  map.ScaleLengths(0.5);
  late.removed_landmarks = {first.landmarks[0]};
  ASSERT_TRUE(map.Apply(late));
  EXPECT_TRUE(map.KeyframePose({2})->translation().isApprox(Eigen::Vector3d(2.5, 0, 0)));
  EXPECT_EQ(map.Find(first.landmarks[0]), nullptr) << "but what is gone is gone";
  const Keyframe third = MakeKeyframe(3, 2.6);
  map.AddKeyframe(third);
  MapUpdate told = UpdateOf({third}, map, 2);
  told.length_factor = 0.5;
  ASSERT_TRUE(map.Apply(told));
  EXPECT_TRUE(map.KeyframePose({3})->translation().isApprox(Eigen::Vector3d(2.6, 0, 0.01)));
  EXPECT_EQ(map.length_factor(), 0.5);
  MapUpdate gap;
  gap.base_revision = 3;
  gap.revision = 4;
  EXPECT_FALSE(map.Apply(gap));
}

TEST(LocalMap, BeginsWithTheLengthsOfTheMapThatIsThere) {
  LocalMap map(TestCamera(4), Pyramid(1.2, 8));
  MapUpdate snapshot;
  snapshot.snapshot = true;
  snapshot.revision = 7;
  snapshot.length_factor = 0.8;
  snapshot.newest_keyframe = {1};
  snapshot.keyframes = {{{1}, {5}, SE3()}};
  ASSERT_TRUE(map.Apply(snapshot));
  EXPECT_EQ(map.length_factor(), 0.8);
  snapshot.length_factor = 0.7;
  ASSERT_TRUE(map.Apply(snapshot));
  EXPECT_EQ(map.length_factor(), 0.8) << "its own, which the back-end will be told";
}

}  // namespace
}  // namespace gw::frontend

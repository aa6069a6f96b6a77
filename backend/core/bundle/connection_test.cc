#include "backend/core/bundle/connection.h"

#include <gtest/gtest.h>

#include "common/good_weights/alpha.h"

namespace gw::backend {
namespace {

// A chain of keyframes K1, K2, ... in which neighbours share as many landmarks as `shared` says.
Map Chain(const std::vector<int>& shared, int num_tracked = 200, double q = 1) {
  constexpr int kFeatures = 600;
  Map map;
  for (size_t k = 0; k <= shared.size(); ++k) {
    Keyframe keyframe;
    keyframe.id = {static_cast<int64_t>(k) + 1};
    keyframe.utime = {static_cast<int64_t>(k) * 1000};
    keyframe.previous = {static_cast<int64_t>(k)};
    keyframe.num_tracked = num_tracked;
    keyframe.q = q;
    keyframe.features.resize(kFeatures);
    for (Feature& feature : keyframe.features) feature.depth = 2;
    keyframe.descriptors.resize(kFeatures);
    keyframe.landmarks.resize(kFeatures);
    map.AddKeyframe(keyframe);
    for (int i = 0; k > 0 && i < shared[k - 1]; ++i) {
      // Even features look back, odd ones ahead: no landmark is in three keyframes.
      const LandmarkId id = LandmarkId::From(keyframe.id, 2 * i);
      map.AddLandmark(id);
      map.AddObservation(id, {keyframe.id, 2 * i});
      map.AddObservation(id, {keyframe.previous, 2 * i + 1});
    }
  }
  return map;
}

std::vector<double> Alphas(const Map& map, double reference) {
  std::vector<double> out;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!keyframe.frame.previous.valid()) continue;
    out.push_back(EdgeScale(Variant::kFull, 1.0 - SmoothedLack(map, id, reference), {}));
  }
  return out;
}

TEST(QualityOfEdge, IsTheShareOfTheReferenceConnection) {
  const Map map = Chain({100, 0, 50, 200});
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {2}, 100), 1.0);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {3}, 100), 0.0);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {4}, 100), 0.5);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {5}, 100), 1.0);
}

TEST(QualityOfEdge, IsNotBetterThanTheTrackingOfItsNewerEnd) {
  const Map map = Chain({100, 20}, 200, 0.3);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {2}, 100), 0.3);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {3}, 100), 0.2);
}

TEST(QualityOfEdge, CountsLandmarksWithDepthOnly) {
  Map map = Chain({100});
  Keyframe far = map.FindKeyframe({2})->frame;  // sees the same again, too far for stereo
  far.id = {3};
  far.utime.us += 1000;
  far.previous = {2};
  for (Feature& feature : far.features) feature.depth = 0;
  map.AddKeyframe(far);
  for (int i = 0; i < 100; ++i) {
    map.AddObservation(LandmarkId::From({2}, 2 * i), {{3}, 2 * i});
  }
  EXPECT_EQ(SharedCloseLandmarks(map, {3}, {2}), 100) << "depth in one of the two is enough";
  Keyframe farther = far;
  farther.id = {4};
  farther.utime.us += 1000;
  farther.previous = {3};
  map.AddKeyframe(farther);
  for (int i = 0; i < 100; ++i) {
    map.AddObservation(LandmarkId::From({2}, 2 * i), {{4}, 2 * i});
  }
  EXPECT_EQ(map.SharedLandmarks({4}, {3}), 100);
  EXPECT_EQ(SharedCloseLandmarks(map, {4}, {3}), 0);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {4}, 100), 0.0);
}

// The picture of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, figure "dr_ba": K4 and K5 are
// poorly connected. Their edges are strongest, those of their neighbours stronger than vision alone
// would make them, fading with distance.
TEST(SmoothedLack, StrengthensTheNeighboursOfPoorlyConnectedKeyframesAndFadesOut) {
  const Map map = Chain({100, 100, 5, 5, 5, 100, 100, 100, 100, 100});
  const std::vector<double> alpha = Alphas(map, 100);  // edges into K2, K3, K4, ...
  ASSERT_EQ(alpha.size(), 10u);
  for (const size_t weak : {2u, 3u, 4u}) EXPECT_GT(alpha[weak], 500);
  EXPECT_LT(alpha[5], alpha[4]);
  EXPECT_LT(alpha[6], alpha[5]);
  EXPECT_LT(alpha[7], alpha[6]);
  EXPECT_GT(alpha[7], 0.1);
  EXPECT_DOUBLE_EQ(alpha[8], 0.1);
  EXPECT_DOUBLE_EQ(alpha[9], 0.1);
  EXPECT_LT(alpha[0], alpha[1]);
  EXPECT_LT(alpha[1], alpha[2]);
  EXPECT_GT(alpha[0], 0.1);
}

TEST(SmoothedLack, NeverWeakensAnEdge) {
  const Map map = Chain({100, 3, 100, 100, 40, 100, 100});
  for (int to = 2; to <= 8; ++to) {
    EXPECT_GE(SmoothedLack(map, {to}, 100), 1.0 - QualityOfEdge(map, {to}, 100));
  }
}

TEST(ConnectionReference, StartsAtTheInitialValueAndBecomesTheMedianOfWellTrackedKeyframes) {
  EXPECT_EQ(ConnectionReference(Chain({100, 100}), {}), 20);
  EXPECT_EQ(ConnectionReference(Chain({100, 140, 120, 200, 80}), {}), 120);
  EXPECT_EQ(ConnectionReference(Chain({100, 140, 120, 200, 80}, 60), {}), 20);
  EXPECT_EQ(ConnectionReference(Chain({5, 4, 3, 2, 1}), {}), 20);
}

}  // namespace
}  // namespace gw::backend

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
    out.push_back(EdgeScale(Variant::kFull, 1.0 - SmoothedLack(map, id, reference, {}), {}));
  }
  return out;
}

TEST(QualityOfEdge, IsTheShareOfTheReferenceConnection) {
  const Map map = Chain({100, 0, 50, 200});
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {2}, 100, {}), 1.0);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {3}, 100, {}), 0.0);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {4}, 100, {}), 0.5);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {5}, 100, {}), 1.0);
}

TEST(QualityOfEdge, IsNotBetterThanTheTrackingOfItsNewerEnd) {
  const Map map = Chain({100, 20}, 200, 0.3);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {2}, 100, {}), 0.3);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {3}, 100, {}), 0.2);
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
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {4}, 100, {}), 0.0);
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
    EXPECT_GE(SmoothedLack(map, {to}, 100, {}), 1.0 - QualityOfEdge(map, {to}, 100, {}));
  }
}

TEST(ConnectionReference, StartsAtTheInitialValueAndBecomesTheMedianOfWellTrackedKeyframes) {
  EXPECT_EQ(ConnectionReference(Chain({100, 100}), {}), 20);
  EXPECT_EQ(ConnectionReference(Chain({100, 140, 120, 200, 80}), {}), 120);
  EXPECT_EQ(ConnectionReference(Chain({100, 140, 120, 200, 80}, 60), {}), 20);
  EXPECT_EQ(ConnectionReference(Chain({5, 4, 3, 2, 1}), {}), 20);
}

// Section III-C of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, values by hand.
const DrWeightConfig kPaper{.method = Method::kPaper};

TEST(PaperLaw, QualityOfAnEdgeIsItsConnectionOverTheReference) {
  Map map = Chain({30, 100}, 200, 0.1);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {2}, 40, kPaper), 0.75) << "whatever the image's own quality";
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {3}, 40, kPaper), 1.0);
  for (int64_t k = 4; k <= 5; ++k) {
    Keyframe far = map.FindKeyframe({3})->frame;
    far.id = {k};
    far.utime = {k * 1000};
    far.previous = {k - 1};
    for (Feature& feature : far.features) feature.depth = 0;
    map.AddKeyframe(far);
    for (int i = 0; i < 30; ++i) map.AddObservation(LandmarkId::From({3}, 2 * i), {{k}, 2 * i});
  }
  EXPECT_EQ(SharedCloseLandmarks(map, {5}, {4}), 0);
  EXPECT_DOUBLE_EQ(QualityOfEdge(map, {5}, 40, kPaper), 0.75) << "far landmarks count";
}

// alpha is 0.1, 1000, 0.1 for the edges into K2, K3, K4 before smoothing. Mean with weights 1 for
// the edge itself and 1/2, 1/4 for those one and two hops away.
TEST(PaperLaw, WeightsAreSmoothedWithCovisibilityDistance) {
  const Map map = Chain({100, 0, 100});
  const auto alpha = [&](int64_t to) {
    return EdgeScale(Variant::kFull, 1.0 - SmoothedLack(map, {to}, 100, kPaper), kPaper);
  };
  EXPECT_NEAR(alpha(2), (0.1 + 1000 / 2.0 + 0.1 / 4) / 1.75, 1e-6);
  EXPECT_NEAR(alpha(3), (0.1 / 2 + 1000 + 0.1 / 2) / 2, 1e-6);
  EXPECT_NEAR(alpha(4), (0.1 / 4 + 1000 / 2.0 + 0.1) / 1.75, 1e-6);
}

// K2 to K5 all see 20 landmarks of K2: every one of them is one hop from every other.
TEST(PaperLaw, CovisibleKeyframesAreNearWhateverTheirOrder) {
  Map map = Chain({100, 0, 0, 0});
  for (int64_t k = 3; k <= 5; ++k) {
    for (int i = 0; i < 20; ++i) map.AddObservation(LandmarkId::From({2}, 2 * i), {{k}, 400 + i});
  }
  const double weak = InformationScale(0.2, kPaper);  // 20 of 100
  const double alpha = EdgeScale(Variant::kFull, 1.0 - SmoothedLack(map, {5}, 100, kPaper), kPaper);
  EXPECT_NEAR(alpha, (weak + weak / 2 + weak / 2 + 0.1 / 2) / 2.5, 1e-6);
}

TEST(PaperLaw, ReferenceIsTheMedianOfTheNewestCovisibilityGraph) {
  EXPECT_EQ(ConnectionReference(Chain({100, 140}, 60), kPaper), 20) << "nothing is well tracked";
  // K6 and its neighbour K5.
  EXPECT_EQ(ConnectionReference(Chain({100, 140, 120, 200, 80}), kPaper), 140);
  EXPECT_EQ(ConnectionReference(Chain({100, 140, 5}), kPaper), 5) << "K4 has no neighbour";
}

}  // namespace
}  // namespace gw::backend

#include "frontend/core/tracking/pose_finder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

constexpr int kLandmarks = 30;

// A keyframe at the origin that sees landmarks spread over the image, 2 to 3 m ahead.
Keyframe View(const RectifiedCamera& camera) {
  Keyframe k;
  k.id = KeyframeId{1};
  for (int i = 0; i < kLandmarks; ++i) {
    CounterRng rng(1, 2, static_cast<uint64_t>(i));
    const int column = i % 6, row = i / 6;
    Feature f;
    f.u = static_cast<float>(60 + 90 * column + rng.Uniform(-10, 10));
    f.v = static_cast<float>(60 + 90 * row + rng.Uniform(-10, 10));
    f.depth = static_cast<float>(rng.Uniform(2, 3));
    f.u_right = f.u - static_cast<float>(camera.bf()) / f.depth;
    Descriptor d{};
    for (uint64_t& word : d) word = rng.NextU64();
    k.features.push_back(f);
    k.descriptors.push_back(d);
    k.landmarks.push_back(LandmarkId::From(k.id, i));
  }
  return k;
}

// A map of that keyframe, and the image from the same place, to be changed by a test.
struct Scene {
  Scene() {
    map.AddKeyframe(view);
    frame.features = view.features;
    frame.descriptors = view.descriptors;
    frame.num_detected = kLandmarks;
  }

  FrontendConfig config;
  RectifiedCamera camera = TestCamera(6);
  Keyframe view = View(camera);
  Pyramid pyramid{config.orb.scale_factor, config.orb.num_levels};
  LocalMap map{camera, pyramid};
  FeatureFrame frame;
  PoseFinder finder{config, camera, pyramid};
};

PosePrediction Predicted(const SE3& T_WC, bool has_prior) {
  PosePrediction prediction;
  prediction.T_WC = T_WC;
  prediction.has_prior = has_prior;
  prediction.search_cov = Matrix6d::Identity() * 1e-4;
  prediction.weight_cov = prediction.honest_cov = Matrix6d::Identity() * 1e-6;
  return prediction;
}

// The image from the same place, in which only so many landmarks are where they should be; the
// others look the same but lie some pixels off, each another way.
FoundPose FindWith(int fitting, bool has_prior) {
  Scene scene;
  std::vector<TrackedPoint> tracked;
  for (int i = 0; i < kLandmarks; ++i) {
    tracked.push_back({scene.view.landmarks[i], scene.view.descriptors[i], 0});
    if (i < fitting) continue;
    CounterRng rng(3, 4, static_cast<uint64_t>(i));
    const double angle = rng.Uniform(0, 6.28);
    scene.frame.features[i].u += static_cast<float>(9 * std::cos(angle));
    scene.frame.features[i].v += static_cast<float>(9 * std::sin(angle));
  }
  const PosePrediction prediction = Predicted(SE3(), has_prior);
  scene.finder.SetImage(&scene.frame, 1);
  return scene.finder.Follow(prediction, tracked, scene.view.id, &scene.map);
}

TEST(PoseFinder, FewInliersOfManyMatchesAreChance) {
  const FoundPose chance = FindWith(13, true);
  EXPECT_FALSE(chance.found);
  EXPECT_EQ(chance.reason, TrackingReason::kTooFewInliers);
  EXPECT_GE(chance.estimate.num_inliers, FrontendConfig().min_inliers);
}

TEST(PoseFinder, AsFewThatAreMostOfTheMatchesAreAPose) {
  EXPECT_TRUE(FindWith(20, true).found);
}

TEST(PoseFinder, WithoutAPriorThereIsNoPredictionToConfirm) {
  EXPECT_TRUE(FindWith(13, false).found);
}

// An image in which so many landmarks lie where the prediction has them, and the others as far from
// a pose that explains none of them to the other side.
FoundPose FollowRestWith(int fitting) {
  Scene scene;
  const SE3 T_turn(ExpSO3({0, 2.8 / scene.camera.fx, 0}), Eigen::Vector3d::Zero());  // 2.8 px aside
  const PosePrediction prediction = Predicted(T_turn, true);
  for (int i = 0; i < kLandmarks; ++i) {
    Feature& f = scene.frame.features[i];
    const Eigen::Vector3d p_W = scene.camera.Unproject(f.u, f.v, f.depth);
    const SE3 T_WC = i < fitting ? T_turn : T_turn.inverse();
    const Eigen::Vector2d pixel = scene.camera.Project(T_WC.inverse() * p_W);
    f.u = static_cast<float>(pixel.x());
    f.v = static_cast<float>(pixel.y());
  }
  FoundPose other;
  other.found = true;
  other.landmarks.resize(kLandmarks);
  scene.finder.SetImage(&scene.frame, 1);
  return scene.finder.FollowRest(prediction, other, scene.view.id, &scene.map);
}

TEST(PoseFinder, TheRestConfirmsWhereMoreFitsThanOnTheOtherSide) {
  EXPECT_TRUE(FollowRestWith(25).found);
}

TEST(PoseFinder, WhatFitsOnBothSidesAlikeIsChance) {
  EXPECT_FALSE(FollowRestWith(15).found);
}

}  // namespace
}  // namespace gw::frontend

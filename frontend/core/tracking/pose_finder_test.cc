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

// The image from the same place, in which only so many landmarks are where they should be; the
// others look the same but lie some pixels off, each another way.
FoundPose FindWith(int fitting, bool has_prior) {
  const RectifiedCamera camera = TestCamera(6);
  const Keyframe view = View(camera);
  const FrontendConfig config;
  const Pyramid pyramid(config.orb.scale_factor, config.orb.num_levels);
  LocalMap map(camera, pyramid);
  map.AddKeyframe(view);
  FeatureFrame frame;
  frame.features = view.features;
  frame.descriptors = view.descriptors;
  frame.num_detected = kLandmarks;
  std::vector<TrackedPoint> tracked;
  for (int i = 0; i < kLandmarks; ++i) {
    tracked.push_back({view.landmarks[i], view.descriptors[i], 0});
    if (i < fitting) continue;
    CounterRng rng(3, 4, static_cast<uint64_t>(i));
    const double angle = rng.Uniform(0, 6.28);
    frame.features[i].u += static_cast<float>(9 * std::cos(angle));
    frame.features[i].v += static_cast<float>(9 * std::sin(angle));
  }
  PosePrediction prediction;
  prediction.has_prior = has_prior;
  prediction.search_cov = Matrix6d::Identity() * 1e-4;
  prediction.weight_cov = prediction.honest_cov = Matrix6d::Identity() * 1e-6;
  PoseFinder finder(config, camera, pyramid);
  finder.SetImage(&frame, 1);
  return finder.Follow(prediction, tracked, view.id, &map);
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
  const RectifiedCamera camera = TestCamera(6);
  const Keyframe view = View(camera);
  const FrontendConfig config;
  const Pyramid pyramid(config.orb.scale_factor, config.orb.num_levels);
  LocalMap map(camera, pyramid);
  map.AddKeyframe(view);
  const SE3 T_turn(ExpSO3({0, 2.8 / camera.fx, 0}), Eigen::Vector3d::Zero());  // 2.8 px aside
  PosePrediction prediction;
  prediction.T_WC = T_turn;
  prediction.has_prior = true;
  prediction.search_cov = Matrix6d::Identity() * 1e-4;
  prediction.weight_cov = prediction.honest_cov = Matrix6d::Identity() * 1e-6;
  FeatureFrame frame;
  frame.features = view.features;
  frame.descriptors = view.descriptors;
  frame.num_detected = kLandmarks;
  for (int i = 0; i < kLandmarks; ++i) {
    Feature& f = frame.features[i];
    const Eigen::Vector3d p_W = camera.Unproject(f.u, f.v, f.depth);
    const SE3 T_WC = i < fitting ? T_turn : T_turn.inverse();
    const Eigen::Vector2d pixel = camera.Project(T_WC.inverse() * p_W);
    f.u = static_cast<float>(pixel.x());
    f.v = static_cast<float>(pixel.y());
  }
  FoundPose other;
  other.found = true;
  other.landmarks.resize(kLandmarks);
  PoseFinder finder(config, camera, pyramid);
  finder.SetImage(&frame, 1);
  return finder.FollowRest(prediction, other, view.id, &map);
}

TEST(PoseFinder, TheRestConfirmsWhereMoreFitsThanOnTheOtherSide) {
  EXPECT_TRUE(FollowRestWith(25).found);
}

TEST(PoseFinder, WhatFitsOnBothSidesAlikeIsChance) {
  EXPECT_FALSE(FollowRestWith(15).found);
}

}  // namespace
}  // namespace gw::frontend

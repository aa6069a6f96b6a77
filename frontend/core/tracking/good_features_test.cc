#include "frontend/core/tracking/good_features.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <set>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

// Landmarks in front of a camera at the origin: most of them in one corner of the image, some
// elsewhere. Every one of them shows as a feature, but for those that are hidden.
struct Scene {
  RectifiedCamera camera;
  Pyramid pyramid{1.2, 8};
  std::vector<MapPoint> points;
  std::vector<Feature> features;
  std::vector<Descriptor> descriptors;

  explicit Scene(int count, double hidden = 0) {
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 400;
    camera.cx = 320;
    camera.cy = 240;
    camera.baseline_m = 0.1;
    camera.depth_max_m = 8;
    CounterRng rng(5, 0, 0);
    for (int i = 0; i < count; ++i) {
      const bool corner = i % 10 != 0;
      const double u = corner ? rng.Uniform(20, 160) : rng.Uniform(20, 620);
      const double v = corner ? rng.Uniform(20, 120) : rng.Uniform(20, 460);
      MapPoint p;
      p.id = LandmarkId::From({1}, i);
      p.p_W = camera.Unproject(u, v, rng.Uniform(1, 6));
      p.normal_W = p.p_W.normalized();
      p.min_distance = 0.1F;
      p.max_distance = static_cast<float>(p.p_W.norm());
      for (uint64_t& word : p.descriptor) word = rng.NextU64();
      points.push_back(p);
      if (rng.Uniform() < hidden) continue;
      Feature f;
      f.u = static_cast<float>(u);
      f.v = static_cast<float>(v);
      f.depth = static_cast<float>(p.p_W.z());
      f.u_right = static_cast<float>(u - camera.bf() / p.p_W.z());
      features.push_back(f);
      descriptors.push_back(p.descriptor);
    }
  }

  ChoiceResult Match(Matching matching, int budget, std::vector<int>* match,
                     uint64_t seed = 1) const {
    std::vector<Candidate> candidates;
    for (const MapPoint& p : points) candidates.push_back({&p, &p.descriptor, -1, 5.0F});
    const FeatureGrid grid(features);
    match->assign(features.size(), -1);
    const Choice choice{matching, budget, seed};
    return GoodFeatures(camera, pyramid)
        .Match(ProjectionMatcher(camera, pyramid), SE3(), candidates, 0,
               {features, descriptors, grid}, {}, choice, match);
  }

  // Information of the pose from what was matched.
  double LogDeterminant(const ChoiceResult& result, const std::vector<int>& match) const {
    Matrix6d H = 1e-5 * Matrix6d::Identity();
    for (size_t i = 0; i < match.size(); ++i) {
      if (match[i] < 0) continue;
      const Eigen::Vector3d& p_C = result.searched[static_cast<size_t>(match[i])].point->p_W;
      const auto J = PoseJacobian(
          ReprojectionJacobian(camera, ObservationOf(features[i], camera, pyramid, p_C.z()), p_C),
          p_C);
      H += J.transpose() * J;
    }
    return std::log(H.determinant());
  }
};

TEST(GoodFeatures, StayWithinTheBudgetAndMatchTheRightFeatures) {
  const Scene scene(600);
  for (const Matching matching : {Matching::kGood, Matching::kRandom}) {
    std::vector<int> match;
    const ChoiceResult result = scene.Match(matching, 100, &match);
    EXPECT_EQ(result.in_view, 600);
    EXPECT_EQ(result.matched, 100);
    EXPECT_EQ(std::count_if(match.begin(), match.end(), [](int m) { return m >= 0; }), 100);
    for (size_t i = 0; i < match.size(); ++i) {
      if (match[i] < 0) continue;
      EXPECT_EQ(result.searched[static_cast<size_t>(match[i])].point->id, scene.points[i].id);
    }
  }
}

TEST(GoodFeatures, TellMoreOfThePoseThanRandomOnes) {
  const Scene scene(600);
  std::vector<int> match;
  const double good = scene.LogDeterminant(scene.Match(Matching::kGood, 60, &match), match);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const ChoiceResult random = scene.Match(Matching::kRandom, 60, &match, seed);
    EXPECT_GT(good, scene.LogDeterminant(random, match) + 2) << seed;
  }
}

TEST(GoodFeatures, WhatIsNotFoundIsReplaced) {
  const Scene scene(600, 0.4);
  std::vector<int> match;
  const ChoiceResult result = scene.Match(Matching::kGood, 100, &match);
  EXPECT_GE(result.matched, 90) << "in four rounds 0.4^4 of them stay unfound, about three";
  EXPECT_LE(result.matched, 100);
  EXPECT_GT(result.searched.size(), 150u);
}

TEST(GoodFeatures, EverythingIsSearchedWhereTheBudgetSuffices) {
  const Scene scene(80);
  std::vector<int> match;
  const ChoiceResult result = scene.Match(Matching::kGood, 100, &match);
  EXPECT_EQ(result.matched, 80);
  EXPECT_EQ(result.evaluations, 0);
}

TEST(GoodFeatures, TheSameInputGivesTheSameChoice) {
  const Scene scene(600);
  std::vector<int> a, b, other;
  scene.Match(Matching::kGood, 100, &a, 7);
  const ChoiceResult result = scene.Match(Matching::kGood, 100, &b, 7);
  scene.Match(Matching::kGood, 100, &other, 8);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, other);
  EXPECT_LE(result.evaluations, 4 * 600) << "ln 10 per candidate in the first round, few after it";
}

// Two candidates tell of the turn about y and of the way along x, the third of what is not known
// yet: by hand, H = diag(100, 100, 100, 100, 100, 1).
TEST(ChooseGood, TakesWhatIsKnownLeast) {
  Matrix6d H = 100 * Matrix6d::Identity();
  H(5, 5) = 1;
  std::vector<Matrix6d> information(3, Matrix6d::Zero());
  information[0](4, 4) = 50;
  information[1](0, 0) = 50;
  information[2](5, 5) = 5;
  std::vector<int> open{0, 1, 2};
  int64_t evaluations = 0;
  // As many draws as needed to see each of three with certainty beyond doubt: 1 of 3 wanted, 7
  // draws; the seed is one that sees all.
  const std::vector<int> chosen = ChooseGood(information, 1, 3, &open, &H, &evaluations);
  EXPECT_EQ(chosen, std::vector<int>{2});
  EXPECT_EQ(evaluations, 7);
  EXPECT_EQ(H(5, 5), 6);
  std::sort(open.begin(), open.end());
  EXPECT_EQ(open, (std::vector<int>{0, 1}));
}

}  // namespace
}  // namespace gw::frontend

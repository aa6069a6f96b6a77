#include "common/vision/pose_ransac.h"

#include <gtest/gtest.h>

namespace gw {
namespace {

RectifiedCamera TestCamera() {
  RectifiedCamera c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 500;
  c.cx = 320;
  c.cy = 240;
  c.baseline_m = 0.1;
  return c;
}

// `right` pairs with pixel and depth noise, `wrong` ones that name any other landmark.
std::vector<PointPair> Pairs(const SE3& T_WC, int right, int wrong, uint64_t seed) {
  const RectifiedCamera camera = TestCamera();
  CounterRng rng(seed, 1, 0);
  std::vector<PointPair> out;
  for (int i = 0; i < right + wrong; ++i) {
    const double z = rng.Uniform(1, 5);
    const Eigen::Vector2d uv(rng.Uniform(20, 620), rng.Uniform(20, 460));
    const Eigen::Vector3d p_C = camera.Unproject(uv.x(), uv.y(), z);
    PointPair pair;
    pair.p_W = T_WC * p_C;
    pair.uv = uv + 0.5 * Eigen::Vector2d(rng.Normal(), rng.Normal());
    pair.p_C = camera.Unproject(pair.uv.x(), pair.uv.y(), z * (1 + 0.01 * rng.Normal()));
    if (i >= right) pair.p_W += Eigen::Vector3d(rng.Uniform(1, 3), rng.Uniform(-2, 2), 0);
    out.push_back(pair);
  }
  return out;
}

TEST(PoseRansac, FindsThePoseAmongTwoThirdsOfWrongPairs) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    CounterRng rng(seed, 2, 0);
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = rng.Uniform(-2, 2);
    const SE3 T_WC = SE3::Exp(d);
    const auto found =
        FindPose(TestCamera(), Pairs(T_WC, 40, 80, seed), 20, CounterRng(seed, 3, 0));
    ASSERT_TRUE(found) << seed;
    EXPECT_GE(found->num_inliers, 25) << seed;
    EXPECT_EQ(found->inlier.size(), 120u);
    EXPECT_LT((found->T_WC.inverse() * T_WC).Log().norm(), 0.1) << seed;
  }
}

TEST(PoseRansac, WrongPairsGiveNoPose) {
  int found = 0;
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    found += FindPose(TestCamera(), Pairs(SE3(), 0, 100, seed), 20, CounterRng(seed, 3, 0)) ? 1 : 0;
  }
  EXPECT_EQ(found, 0);
}

TEST(PoseRansac, TooFewPairsGiveNoPose) {
  EXPECT_FALSE(FindPose(TestCamera(), {}, 0, CounterRng(1, 1, 1)));
  EXPECT_FALSE(FindPose(TestCamera(), Pairs(SE3(), 2, 0, 1), 0, CounterRng(1, 1, 1)));
}

}  // namespace
}  // namespace gw

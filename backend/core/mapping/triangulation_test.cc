#include "backend/core/mapping/triangulation.h"

#include <gtest/gtest.h>

#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

MappingContext Context() {
  return MappingContext({}, {}, TestCamera());
}

// What a camera at T_WC sees of p_W; with_depth also in the virtual right image.
PosedFeature Look(const SE3& T_WC, const Eigen::Vector3d& p_W, bool with_depth) {
  const RectifiedCamera camera = TestCamera();
  PosedFeature view{T_WC, T_WC.inverse(), {}};
  const Eigen::Vector3d p_C = view.T_CW * p_W;
  const Eigen::Vector2d uv = camera.Project(p_C);
  view.feature.u = static_cast<float>(uv.x());
  view.feature.v = static_cast<float>(uv.y());
  view.feature.level = 2;
  if (with_depth) {
    view.feature.depth = static_cast<float>(p_C.z());
    view.feature.u_right = view.feature.u - static_cast<float>(camera.bf() / p_C.z());
  }
  return view;
}

TEST(Triangulate, FindsThePointFromEveryKindOfView) {
  const MappingContext context = Context();
  for (uint64_t seed = 0; seed < 300; ++seed) {
    CounterRng rng(seed, 1, 0);
    const Eigen::Vector3d p_W(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(2, 5));
    const SE3 T_WA(ExpSO3({rng.Uniform(-.1, .1), 0, 0}), {0, 0, 0});
    const SE3 T_WB(ExpSO3({0, rng.Uniform(-.1, .1), 0}), {rng.Uniform(0.2, 0.6), 0.1, 0.2});
    for (const bool depth_a : {false, true}) {
      for (const bool depth_b : {false, true}) {
        const auto found = Triangulate(context, Look(T_WA, p_W, depth_a), Look(T_WB, p_W, depth_b));
        ASSERT_TRUE(found) << seed;
        EXPECT_LT((*found - p_W).norm(), 1e-3 * p_W.norm()) << seed;
      }
    }
  }
}

TEST(Triangulate, RefusesRaysThatAreParallelWithoutDepth) {
  const Eigen::Vector3d p_W(0, 0, 4);
  const PosedFeature a = Look(SE3(), p_W, false);
  const PosedFeature near_a = Look(SE3({1, 0, 0, 0}, {0.01, 0, 0}), p_W, false);
  EXPECT_FALSE(Triangulate(Context(), a, near_a));
  // With depth on one side the other only has to agree.
  EXPECT_TRUE(Triangulate(Context(), Look(SE3(), p_W, true), near_a));
}

TEST(Triangulate, RefusesRaysThatDoNotMeet) {
  const Eigen::Vector3d p_W(0, 0, 4);
  const PosedFeature a = Look(SE3(), p_W, false);
  PosedFeature b = Look(SE3({1, 0, 0, 0}, {0.5, 0, 0}), p_W, false);
  b.feature.v += 12;
  EXPECT_FALSE(Triangulate(Context(), a, b));
  b.feature.v -= 12;
  b.feature.u += 150;  // crosses behind the cameras
  EXPECT_FALSE(Triangulate(Context(), a, b));
}

TEST(Triangulate, RefusesSizesThatDoNotFitTheDistances) {
  const Eigen::Vector3d p_W(0, 0, 4);
  const PosedFeature a = Look(SE3(), p_W, false);
  PosedFeature b = Look(SE3({1, 0, 0, 0}, {0.5, 0, 0}), p_W, false);
  b.feature.level = 6;  // twice the size from the same distance
  EXPECT_FALSE(Triangulate(Context(), a, b));
}

}  // namespace
}  // namespace gw::backend

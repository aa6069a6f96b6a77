#include "frontend/core/place/piece_start.h"

#include <gtest/gtest.h>

#include <functional>

#include "common/core/random.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

RectifiedCamera Camera() {
  return TestCamera(6);
}

// A cloud of points before the camera, seen from T_SceneC.
FeatureFrame See(const SE3& T_SceneC) {
  const RectifiedCamera camera = Camera();
  FeatureFrame frame;
  CounterRng points(7, 1, 0);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(8 * points.Uniform() - 4, 5 * points.Uniform() - 2.5,
                            2 + 4 * points.Uniform());
    Descriptor descriptor;
    for (uint64_t& word : descriptor) word = points.NextU64();
    const Eigen::Vector3d p_C = T_SceneC.inverse() * p;
    if (p_C.z() < 0.3 || !camera.InImage(camera.Project(p_C))) continue;
    const Eigen::Vector2d uv = camera.Project(p_C);
    Feature f;
    f.u = static_cast<float>(uv.x());
    f.v = static_cast<float>(uv.y());
    f.depth = static_cast<float>(p_C.z());
    frame.features.push_back(f);
    frame.descriptors.push_back(descriptor);
  }
  frame.num_detected = static_cast<int>(frame.features.size());
  return frame;
}

// The camera goes sideways at 0.3 m/s, ten images a second.
SE3 Way(int image) {
  return SE3(Eigen::Quaterniond::Identity(), {0.03 * image, 0, 0});
}

// Images until a piece is begun, -1: never. scene_moves: what is seen goes along with the camera.
int Begun(bool scene_moves, const std::function<std::optional<SE3>(int)>& odometry,
          int known_at = -1) {
  PieceStart start(Camera());
  for (int i = 0; i < 100; ++i) {
    const FeatureFrame seen = See(scene_moves ? SE3() : Way(i));
    if (start.Observe({i * 100'000}, i == known_at, seen, odometry(i))) return i;
  }
  return -1;
}

TEST(PieceStart, IsBegunWhenThePlaceHasBeenUnknownForAWhile) {
  const int begun = Begun(false, Way);
  EXPECT_GE(begun, 30);
  EXPECT_LE(begun, 41);
  EXPECT_GE(Begun(false, Way, 20), 51);  // known again meanwhile
}

TEST(PieceStart, NotBeforeWhatMovesWithTheCamera) {
  EXPECT_EQ(Begun(true, Way), -1);
}

TEST(PieceStart, NotWhileTheRobotStandsOrDeadReckoningIsNotThere) {
  EXPECT_EQ(Begun(true, [](int) { return SE3(); }), -1);
  EXPECT_EQ(Begun(false, [](int) { return std::nullopt; }), -1);
}

TEST(PieceStart, NotWhereDeadReckoningContradictsTheImages) {
  EXPECT_EQ(Begun(false, [](int i) { return Way(-i); }), -1);
}

}  // namespace
}  // namespace gw::frontend

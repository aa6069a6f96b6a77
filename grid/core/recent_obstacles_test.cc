#include "grid/core/recent_obstacles.h"

#include <gtest/gtest.h>

#include <numbers>

#include "grid/core/test_scene.h"

namespace gw::grid {
namespace {

class RecentObstaclesTest : public testing::Test {
 protected:
  RecentObstaclesTest()
      : source_(MakeDepthSource(SceneGeometry(), config_)),
        scanner_(source_->rays(), config_),
        obstacles_(config_, 0.18) {}

  ObstacleView Push(double t, const Scene& scene, const SE3& T_OB, uint32_t epoch = 0) {
    return obstacles_.Push(Utime{static_cast<int64_t>(t * 1e6)}, T_OB, epoch,
                           scanner_.Scan(SceneDepth(scene, source_->rays(), T_OB)));
  }

  GridConfig config_;
  std::unique_ptr<DepthSource> source_;
  FloorScanner scanner_;
  RecentObstacles obstacles_;
  const Scene box_{{{{1, -0.1, 0}, {1.2, 0.1, 0.4}}}, {}};
};

TEST_F(RecentObstaclesTest, AreThereAtOnceNearestFirst) {
  const ObstacleView view = Push(1, box_, SE3());
  ASSERT_FALSE(view.obstacles.empty());
  EXPECT_NEAR(view.obstacles.front().x(), 1.02, 0.05);
  for (size_t i = 1; i < view.obstacles.size(); ++i) {
    EXPECT_LE(view.obstacles[i - 1].norm(), view.obstacles[i].norm());
  }
  EXPECT_NEAR(view.seen_ahead_m, 1, 0.15);
}

TEST_F(RecentObstaclesTest, AreRememberedOutOfViewForAWhile) {
  Push(1, box_, SE3());
  const SE3 turned = OnFloor(0, 0, std::numbers::pi / 2);
  const ObstacleView view = Push(2, box_, turned);
  ASSERT_FALSE(view.obstacles.empty());
  EXPECT_NEAR(view.obstacles.front().y(), -1.02, 0.06);  // to the right now
  EXPECT_TRUE(Push(2 + config_.memory_s, box_, turned).obstacles.empty());
}

TEST_F(RecentObstaclesTest, GoWhenTheFloorIsSeenInTheirPlace) {
  for (int i = 0; i < 20; ++i) Push(1 + 0.1 * i, box_, SE3());
  ObstacleView view;
  for (int i = 0; i < 5; ++i) view = Push(3 + 0.1 * i, {}, SE3());
  EXPECT_TRUE(view.obstacles.empty());
}

TEST_F(RecentObstaclesTest, AreForgottenWhenOdometryBeginsAnew) {
  Push(1, box_, SE3());
  const SE3 turned = OnFloor(0, 0, std::numbers::pi / 2);
  EXPECT_TRUE(Push(2, box_, turned, 1).obstacles.empty());
}

TEST_F(RecentObstaclesTest, WithoutOdometryOnlyTheNewestScanCounts) {
  Push(1, box_, SE3());
  const FloorScan empty = scanner_.Scan(SceneDepth({}, source_->rays(), SE3()));
  EXPECT_TRUE(obstacles_.Push(Utime{2'000'000}, std::nullopt, 0, empty).obstacles.empty());
}

}  // namespace
}  // namespace gw::grid

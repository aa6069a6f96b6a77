#include "grid/core/floor_scan.h"

#include <gtest/gtest.h>

#include <functional>

#include "grid/core/recent_obstacles.h"
#include "grid/core/test_scene.h"

namespace gw::grid {
namespace {

// From B, straight ahead: what the middle bearing saw.
struct Ahead {
  std::vector<double> hits;
  double free_to = 0;
  bool FreeAt(double x) const {
    return std::any_of(free.begin(), free.end(), [x](const FloorScan::Stretch& s) {
      return s.from + 0.1 <= x && x <= s.to + 0.1;
    });
  }
  std::vector<FloorScan::Stretch> free;
};

class FloorScanTest : public testing::Test {
 protected:
  FloorScan Scan(const Scene& scene, const GridConfig& config = {},
                 const std::function<void(DepthImage*)>& spoil = nullptr) {
    const auto source = MakeDepthSource(SceneGeometry(), config);
    DepthImage depth = SceneDepth(scene, source->rays(), OnFloor(0, 0, 0));
    if (spoil) spoil(&depth);
    return FloorScanner(source->rays(), config).Scan(depth);
  }
  static Ahead LookAhead(const FloorScan& scan) {
    Ahead ahead;
    const int middle = scan.num_bearings / 2;
    for (const FloorScan::Hit& hit : scan.HitsAt(middle)) ahead.hits.push_back(hit.range + 0.1);
    const auto free = scan.FreeAt(middle);
    ahead.free.assign(free.begin(), free.end());
    for (const FloorScan::Stretch& s : free) ahead.free_to = std::max(ahead.free_to, s.to + 0.1);
    return ahead;
  }
};

constexpr double kFar = 20;

TEST_F(FloorScanTest, TheFloorIsFreeUpToAWall) {
  const Ahead ahead = LookAhead(Scan({{{{2, -kFar, 0}, {3, kFar, 2}}}, {}}));
  ASSERT_EQ(ahead.hits.size(), 1u);
  EXPECT_NEAR(ahead.hits[0], 2, 0.01);
  EXPECT_TRUE(ahead.FreeAt(0.7));
  EXPECT_TRUE(ahead.FreeAt(1.8));
  EXPECT_LT(ahead.free_to, 2);
}

TEST_F(FloorScanTest, ABearingPointsWhereTheCameraLooks) {
  const FloorScan scan = Scan({{{{2, 0.3, 0}, {3, kFar, 2}}}, {}});  // to the left
  for (int bin = 0; bin < scan.num_bearings; ++bin) {
    const bool left = std::tan(scan.bearing(bin)) * 1.9 > 0.33;
    const bool right = std::tan(scan.bearing(bin)) * 2.9 < 0.27;
    if (left || right) {
      EXPECT_EQ(scan.HitsAt(bin).empty(), right) << bin;
    }
  }
}

TEST_F(FloorScanTest, HeightsBetweenFloorAndRobotTopAreObstacles) {
  const auto hits = [this](double from, double to) {
    return LookAhead(Scan({{{{1.5, -kFar, from}, {1.8, kFar, to}}}, {}})).hits.size();
  };
  EXPECT_EQ(hits(0, 0.03), 0u);    // a threshold that the robot climbs
  EXPECT_GT(hits(0, 0.2), 0u);     // a box
  EXPECT_GT(hits(0.3, 0.34), 0u);  // a low table
  EXPECT_EQ(hits(0.6, 0.64), 0u);  // a high one
}

TEST_F(FloorScanTest, UnderAHighTableTheFloorIsFree) {
  const Ahead ahead = LookAhead(Scan({{{{1, -kFar, 0.6}, {2, kFar, 0.65}}}, {}}));
  EXPECT_TRUE(ahead.FreeAt(1.5));
  EXPECT_TRUE(ahead.hits.empty());
}

TEST_F(FloorScanTest, TheEdgeOfAHoleIsAnObstacle) {
  const Ahead ahead = LookAhead(Scan({{}, {{{1.5, -kFar, 0}, {1.9, kFar, 0}}}}));
  ASSERT_FALSE(ahead.hits.empty());
  EXPECT_NEAR(ahead.hits.front(), 1.5, 0.06);
  EXPECT_TRUE(ahead.FreeAt(1.2));
  EXPECT_FALSE(ahead.FreeAt(1.6));
}

TEST_F(FloorScanTest, NothingIsFreeWhereTheFloorWasNotSeen) {
  // A wall behind a floor without texture: depth on the wall alone.
  const Scene scene{{{{2, -kFar, 0}, {3, kFar, 2}}}, {}};
  const FloorScan scan = Scan(scene, {}, [](DepthImage* depth) {
    const size_t horizon = depth->size() / 2;
    for (size_t i = horizon; i < depth->size(); ++i) {
      if ((*depth)[i] < 1.85f) (*depth)[i] = 0;
    }
  });
  const Ahead ahead = LookAhead(scan);
  EXPECT_FALSE(ahead.hits.empty());
  EXPECT_TRUE(ahead.free.empty());
}

TEST_F(FloorScanTest, NoDepthSaysNothing) {
  const FloorScan scan =
      Scan({}, {}, [](DepthImage* depth) { std::fill(depth->begin(), depth->end(), 0.0f); });
  EXPECT_TRUE(scan.free.empty());
  EXPECT_TRUE(scan.hits.empty());
  EXPECT_EQ(SeenAhead(scan, 0.2), 0);
}

TEST_F(FloorScanTest, SinglePixelsAreNoObstacle) {
  const FloorScan scan = Scan({}, {}, [](DepthImage* depth) {
    for (size_t i = 7; i < depth->size(); i += 5003) (*depth)[i] = 0.7f;
  });
  EXPECT_TRUE(scan.hits.empty());
}

TEST_F(FloorScanTest, ATiltedCameraSeesNoObstaclesInTheFloor) {
  GridConfig config;
  const auto source = MakeDepthSource(SceneGeometry(), config);
  const SE3 tilted = OnFloor(0, 0, 0) * SE3(ExpSO3({0, 0.0175, 0}), {0, 0, 0});
  for (const SE3& T : {tilted, tilted.inverse()}) {
    const FloorScan scan =
        FloorScanner(source->rays(), config).Scan(SceneDepth({}, source->rays(), T));
    EXPECT_TRUE(scan.hits.empty());
  }
}

TEST_F(FloorScanTest, SeesAheadToTheFirstThingInItsWay) {
  const Scene beside{{{{1, 0.5, 0}, {1.4, 0.9, 1}}}, {}};
  const Scene before{{{{1, -0.1, 0}, {1.4, 0.3, 1}}}, {}};
  EXPECT_GT(SeenAhead(Scan(beside), 0.2), 2.5);
  EXPECT_NEAR(SeenAhead(Scan(before), 0.2), 1, 0.15);
}

}  // namespace
}  // namespace gw::grid

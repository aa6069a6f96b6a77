#include "grid/core/grid_map.h"

#include <gtest/gtest.h>

#include "grid/core/floor_image.h"
#include "grid/core/scan_evidence.h"
#include "grid/core/test_scene.h"

namespace gw::grid {
namespace {

constexpr double kFar = 20;

// A robot that drives along a wall, with a keyframe every half metre.
class GridMapTest : public testing::Test {
 protected:
  GridMapTest()
      : source_(MakeDepthSource(SceneGeometry(), config_)), scanner_(source_->rays(), config_) {}

  GridMap NewMap() const { return {config_, T_BC(), 0.18}; }
  static SE3 T_BC() { return SceneCalibration().camera.T_BC; }
  FloorScan See(const Scene& scene, const SE3& T_WB) const {
    return scanner_.Scan(SceneDepth(scene, source_->rays(), T_WB));
  }
  static MapUpdate Keyframes(const std::vector<std::pair<int64_t, SE3>>& bodies,
                             int64_t epoch = 0) {
    MapUpdate update;
    for (const auto& [id, T_WB] : bodies) {
      update.keyframes.push_back({{id}, Utime{epoch + id * 1000}, T_WB * T_BC()});
    }
    return update;
  }
  // An image of the body at T_WB, tracked against a keyframe whose body is at T_WK.
  static FramePose PoseOf(const SE3& T_WB, int64_t keyframe, const SE3& T_WK) {
    FramePose pose;
    pose.utime = Utime{keyframe * 1000};
    pose.status = TrackingStatus::kTracking;
    pose.T_WB = T_WB;
    pose.reference_keyframe = {keyframe};
    pose.T_KC = (T_WK * T_BC()).inverse() * T_WB * T_BC();
    return pose;
  }
  static CellState StateAt(const GridMap& map, double x, double y) {
    const Index2 cell{static_cast<int32_t>(std::floor(x / map.cell_m())),
                      static_cast<int32_t>(std::floor(y / map.cell_m()))};
    const auto tile = map.tiles().find(TileOf(cell));
    if (tile == map.tiles().end()) return CellState::kUnknown;
    return tile->second.cells[CellTiles::Offset(cell)];
  }
  void Look(GridMap* map, const Scene& scene, const SE3& T_WB, int64_t keyframe, const SE3& T_WK,
            int times) const {
    const FloorScan scan = See(scene, T_WB);
    for (int i = 0; i < times; ++i) map->Add(PoseOf(T_WB, keyframe, T_WK), scan);
  }

  GridConfig config_;
  std::unique_ptr<DepthSource> source_;
  FloorScanner scanner_;
  const Scene wall_{{{{2, -kFar, 0}, {3, kFar, 2}}}, {}};
};

TEST_F(GridMapTest, AWallIsOccupiedTheFloorBeforeItFreeTheRestUnknown) {
  GridMap map = NewMap();
  const SE3 T = OnFloor(0.3, 0.2, 0.1);
  map.Apply(Keyframes({{1, T}}));
  Look(&map, wall_, T, 1, T, 4);
  map.Compose();
  EXPECT_EQ(StateAt(map, 2.02, 0.4), CellState::kOccupied);
  EXPECT_EQ(StateAt(map, 1.6, 0.4), CellState::kFree);
  EXPECT_EQ(StateAt(map, 0.3, 0.2), CellState::kFree);  // where it stands
  EXPECT_EQ(StateAt(map, 2.3, 0.4), CellState::kUnknown);
  EXPECT_EQ(StateAt(map, -1, 0.2), CellState::kUnknown);  // behind it
}

TEST_F(GridMapTest, OneLookIsNotEnough) {
  GridMap map = NewMap();
  map.Apply(Keyframes({{1, SE3()}}));
  Look(&map, wall_, SE3(), 1, SE3(), 1);
  map.Compose();
  EXPECT_EQ(StateAt(map, 2.02, 0.4), CellState::kUnknown);
  EXPECT_EQ(StateAt(map, 1.5, 0.0), CellState::kUnknown);
}

TEST_F(GridMapTest, BlindAndUncertainImagesMakeNothing) {
  GridMap map = NewMap();
  map.Apply(Keyframes({{1, SE3()}}));
  const FloorScan scan = See(wall_, SE3());
  for (const TrackingStatus status : {TrackingStatus::kInitializing, TrackingStatus::kDrOnly,
                                      TrackingStatus::kRecovering, TrackingStatus::kLost}) {
    FramePose pose = PoseOf(SE3(), 1, SE3());
    pose.status = status;
    EXPECT_FALSE(map.Add(pose, scan));
  }
  FramePose uncertain = PoseOf(SE3(), 1, SE3());
  uncertain.cov_T_WB(0, 0) = 0.1 * 0.1;
  EXPECT_FALSE(map.Add(uncertain, scan));
  FramePose jumpy = PoseOf(SE3(), 1, SE3());
  jumpy.motion_us = FramePose::kMotionSpan.us;
  jumpy.cov_motion(5, 5) = 0.1 * 0.1;
  EXPECT_FALSE(map.Add(jumpy, scan));
  EXPECT_EQ(map.counters().blind, 4);
  EXPECT_EQ(map.counters().uncertain, 2);
  EXPECT_TRUE(map.Compose().empty());
}

// The drift of the map as a whole does not blur what is seen beside a keyframe.
TEST_F(GridMapTest, APoseThatHasDriftedWithItsKeyframeIsSharp) {
  GridMap map = NewMap();
  map.Apply(Keyframes({{1, SE3()}}));
  FramePose drifted = PoseOf(SE3(), 1, SE3());
  drifted.cov_T_WB(0, 0) = 1;
  drifted.motion_us = FramePose::kMotionSpan.us;
  drifted.cov_motion = 1e-6 * Matrix6d::Identity();
  EXPECT_TRUE(map.Add(drifted, See(wall_, SE3())));
}

// The whole after a correction is what it would be had the keyframes been there from the begin, and
// only what the correction touches was composed again.
TEST_F(GridMapTest, CorrectionsMoveTheGridsAndNothingElse) {
  const auto body = [](int i, double bend) { return OnFloor(0.1, 1.5 * i, bend * i); };
  const Scene room{{{{1.6, -kFar, 0}, {2, kFar, 2}}}, {}};
  const auto build = [&](double bend) {
    GridMap map = NewMap();
    for (int i = 1; i <= 6; ++i) {
      map.Apply(Keyframes({{i, body(i, i > 4 ? bend : 0)}}));
      // Seen from the same place relative to the keyframe, whatever was believed of that.
      const FloorScan scan = See(room, body(i, 0));
      for (int k = 0; k < 3; ++k) map.Add(PoseOf(body(i, 0), i, body(i, 0)), scan);
    }
    map.Compose();
    return map;
  };
  GridMap corrected = build(0);
  const int64_t composed = corrected.counters().tiles_composed;
  MapUpdate correction;
  for (int i = 1; i <= 6; ++i) {
    const MapUpdate one = Keyframes({{i, body(i, i > 4 ? 0.05 : 0)}});
    correction.keyframes.push_back(one.keyframes[0]);
  }
  corrected.Apply(correction);
  const auto changed = corrected.Compose();
  EXPECT_EQ(corrected.counters().grids_moved, 2);
  EXPECT_FALSE(changed.empty());
  EXPECT_LT(corrected.counters().tiles_composed - composed,
            static_cast<int64_t>(corrected.tiles().size()));
  EXPECT_TRUE(corrected.Compose().empty());

  GridMap again = NewMap();
  again.Apply(correction);
  again.Restore(corrected.Save());
  again.Compose();
  for (const auto& [index, tile] : again.tiles()) {
    ASSERT_TRUE(corrected.tiles().contains(index));
    EXPECT_EQ(corrected.tiles().at(index).cells, tile.cells) << index.x << " " << index.y;
  }
}

TEST_F(GridMapTest, APersonWhoLeavesFadesAlsoFromAnotherKeyframe) {
  const Scene person{{{{1.2, -0.2, 0}, {1.5, 0.2, 1.7}}, wall_.boxes[0]}, {}};
  GridMap map = NewMap();
  const SE3 other = OnFloor(0.1, 0, 0);
  map.Apply(Keyframes({{1, SE3()}, {2, other}, {3, other}, {4, other}}));
  Look(&map, person, SE3(), 1, SE3(), 50);
  map.Compose();
  EXPECT_EQ(StateAt(map, 1.22, 0), CellState::kOccupied);
  for (int64_t id = 2; id <= 4; ++id) Look(&map, wall_, other, id, other, 10);
  map.Compose();
  EXPECT_EQ(StateAt(map, 1.22, 0), CellState::kFree);
  EXPECT_EQ(StateAt(map, 2.02, 0), CellState::kOccupied);
}

TEST_F(GridMapTest, AChairThatWasNotThereAppears) {
  const Scene chair{{{{1.2, -0.2, 0}, {1.5, 0.2, 0.5}}, wall_.boxes[0]}, {}};
  GridMap map = NewMap();
  map.Apply(Keyframes({{1, SE3()}, {2, SE3()}}));
  Look(&map, wall_, SE3(), 1, SE3(), 100);
  map.Compose();
  EXPECT_EQ(StateAt(map, 1.22, 0), CellState::kFree);
  Look(&map, chair, SE3(), 2, SE3(), 8);
  map.Compose();
  EXPECT_EQ(StateAt(map, 1.22, 0), CellState::kOccupied);
}

TEST_F(GridMapTest, TheGridOfARemovedKeyframeGoesToItsParent) {
  const SE3 first = OnFloor(0.1, 0.1, 0), second = OnFloor(0.5, 0.1, 0);
  for (const bool parent_has_grid : {false, true}) {
    GridMap map = NewMap();
    map.Apply(Keyframes({{1, first}, {2, second}}));
    if (parent_has_grid) Look(&map, wall_, first, 1, first, 1);
    Look(&map, wall_, second, 2, second, 4);
    map.Compose();
    const auto before = map.tiles();
    MapUpdate removal;
    removal.removed_keyframes.push_back({{2}, {1}, (first * T_BC()).inverse() * (second * T_BC())});
    map.Apply(removal);
    map.Compose();
    ASSERT_EQ(map.Save().size(), 1u);
    for (const auto& [index, tile] : before) EXPECT_EQ(map.tiles().at(index).cells, tile.cells);
    // An image that was tracked before the front-end knew still finds its place.
    EXPECT_TRUE(map.Add(PoseOf(second, 2, second), See(wall_, second)));
    EXPECT_EQ(map.Save().size(), 1u);
  }
}

TEST_F(GridMapTest, AnotherMapBeginsAnotherGrid) {
  GridMap map = NewMap();
  map.Apply(Keyframes({{1, SE3()}}));
  Look(&map, wall_, SE3(), 1, SE3(), 4);
  EXPECT_FALSE(map.Apply(Keyframes({{1, OnFloor(0, 0, 0.1)}})));  // moved, but the same
  map.Compose();
  EXPECT_FALSE(map.tiles().empty());
  EXPECT_TRUE(map.Apply(Keyframes({{1, SE3()}}, 77'000'000)));
  EXPECT_TRUE(map.tiles().empty());
  EXPECT_TRUE(map.Save().empty());
}

TEST_F(GridMapTest, CorrectedLengthsBeginAnotherGrid) {
  GridMap map = NewMap();
  MapUpdate update = Keyframes({{1, SE3()}});
  update.length_factor = 0.9;
  EXPECT_FALSE(map.Apply(update)) << "the lengths that it begins with";
  Look(&map, wall_, SE3(), 1, SE3(), 3);
  map.Compose();
  EXPECT_FALSE(map.tiles().empty());
  update.length_factor = 0.8;
  EXPECT_TRUE(map.Apply(update));
  map.Compose();
  EXPECT_TRUE(map.tiles().empty());
  EXPECT_EQ(map.length_factor(), 0.8);
}

TEST_F(GridMapTest, AKeyframeThatTheMapDoesNotHaveYetIsWhereItsImageWas) {
  const SE3 T = OnFloor(0.1, 0, 0);
  GridMap map = NewMap();
  Look(&map, wall_, T, 1, T, 4);
  map.Compose();
  EXPECT_EQ(StateAt(map, 2.02, 0.4), CellState::kOccupied);
  map.Apply(Keyframes({{1, OnFloor(0.6, 0, 0)}}));
  map.Compose();
  EXPECT_EQ(StateAt(map, 2.52, 0.4), CellState::kOccupied);
  EXPECT_NE(StateAt(map, 2.02, 0.4), CellState::kOccupied);
}

TEST(ScanEvidence, EveryCellOccursOnceInOrder) {
  const GridConfig config;
  const auto source = MakeDepthSource(SceneGeometry(), config);
  const Scene room{{{{1.5, -1, 0}, {1.8, 1, 2}}}, {}};
  const FloorScan scan =
      FloorScanner(source->rays(), config).Scan(SceneDepth(room, source->rays(), SE3()));
  const auto evidence = EvidenceOf(scan, Pose2({3, -2}, 2.5), 0.05, 0.18);
  ASSERT_FALSE(evidence.empty());
  for (size_t i = 1; i < evidence.size(); ++i) {
    EXPECT_TRUE(evidence[i - 1].index < evidence[i].index);
  }
  EXPECT_TRUE(std::any_of(evidence.begin(), evidence.end(),
                          [](const CellEvidence& e) { return e.cell.log_odds > 0; }));
}

}  // namespace
}  // namespace gw::grid

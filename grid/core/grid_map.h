// The floor map: local grids that hang on keyframes, and their sum in W.
//
// A scan is added to the grid of its image's reference keyframe, by the pose relative to that
// keyframe, which no later correction of the map changes. When keyframes move (local BA, loops,
// global BA, merges), their grids move with them, and the tiles of the sum that they touch, before
// or after, are composed again; all others stay. Grids are summed in the order of their keyframes,
// with the bounds of scan_evidence.h after each: what was seen later wins.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/config/grid_config.h"
#include "common/contract/grid.h"
#include "common/contract/map.h"
#include "common/contract/tracking.h"
#include "grid/core/floor_scan.h"
#include "grid/core/local_grid.h"

namespace gw::grid {

struct GridMapCounters {
  int64_t scans = 0;           // added
  int64_t blind = 0;           // not added: the image has no pose from vision
  int64_t uncertain = 0;       // not added: the pose would blur the map
  int64_t grids_moved = 0;     // local grids that a correction of the map moved
  int64_t tiles_composed = 0;  // of the sum
};

class GridMap {
 public:
  // T_BC: rectified camera in the body. footprint_m: radius of the robot.
  GridMap(const GridConfig& config, const SE3& T_BC, double footprint_m)
      : cell_m_(config.cell_m),
        max_range_(config.max_range_m),
        footprint_m_(footprint_m),
        T_BC_(T_BC) {}

  // Updates may be missing: each tells whole poses. True: this is another map than before (its
  // keyframes are of other images), or its lengths were corrected, and the grid begins anew.
  bool Apply(const MapUpdate& update);

  // False: not added, the image says nothing of where it was taken (see counters).
  bool Add(const FramePose& pose, const FloorScan& scan);

  // Brings the sum up to date. The tiles that changed, with their new version; sorted.
  std::vector<GridTile> Compose();

  const std::map<Index2, GridTile>& tiles() const { return tiles_; }
  int64_t version() const { return version_; }  // of the newest tile
  // Factor of the map's lengths, by its newest update; 1 before the first.
  double length_factor() const { return length_factor_.value_or(1); }
  int64_t map_revision() const { return map_revision_; }
  Utime utime() const { return utime_; }  // of the newest image added
  double cell_m() const { return cell_m_; }
  const GridMapCounters& counters() const { return counters_; }

  // What is kept of a map from day to day: the local grids. A grid whose keyframe is not in the map
  // (yet) waits for it.
  struct SavedGrid {
    KeyframeId keyframe;
    Utime keyframe_utime;  // zero: not known to the map yet
    LocalGrid grid;
  };
  std::vector<SavedGrid> Save() const;  // sorted by keyframe
  // Precondition: nothing was added yet.
  void Restore(std::vector<SavedGrid> grids);

 private:
  struct Piece {
    LocalGrid grid;
    Utime keyframe_utime;
    std::optional<Pose2> T_WL;  // as composed
    std::set<Index2> touched;   // tiles of the sum
  };
  struct Placed {
    Pose2 T_WK;
    Utime utime;
  };
  struct Removed {
    KeyframeId parent;
    Pose2 T_ParentK;
  };

  Pose2 BodyPose(const SE3& T_WC) const { return Pose2(T_WC * T_BC_.inverse()); }
  bool IsOtherMap(const MapUpdate& update) const;
  void Remove(const KeyframeRemoval& removal);
  void Place(KeyframeId id, Piece* piece, const Pose2& T_WK);
  void Touch(KeyframeId id, Piece* piece, Index2 local_tile);
  void Detach(KeyframeId id, Piece* piece);
  bool IsSharp(const FramePose& pose) const;

  double cell_m_;
  double max_range_;
  double footprint_m_;
  SE3 T_BC_;
  std::map<KeyframeId, Piece> pieces_;
  std::map<KeyframeId, Placed> keyframes_;
  std::map<KeyframeId, Removed> removed_;
  std::map<Index2, std::set<KeyframeId>> pieces_of_tile_;
  std::set<Index2> dirty_;
  std::map<Index2, GridTile> tiles_;
  int64_t version_ = 0;
  int64_t map_revision_ = 0;
  std::optional<double> length_factor_;
  Utime utime_;
  GridMapCounters counters_;
};

}  // namespace gw::grid

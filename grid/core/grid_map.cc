#include "grid/core/grid_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "grid/core/scan_evidence.h"

namespace gw::grid {
namespace {

// Sums of two looks that agree: one look alone may be noise.
constexpr float kOccupiedFrom = 2 * Cell::kHit - 0.3f;
constexpr float kFreeFrom = 2 * Cell::kMiss;

// Far looks at a wall put hits behind it, which nothing takes away. A cell is part of the wall only
// if its hits are this sharp, of the sharpest within kThinning cells; else it is not known.
constexpr int kThinning = 3;
constexpr float kLeastSharpness = 0.3f;

// A grid is composed again when a corner of it has moved by this part of a cell.
constexpr double kMovedCells = 0.25;

// A pose is sharp enough when one sigma of its motion over the last second moves what is seen
// half-way out by at most a cell: so far it fits what was seen beside the same keyframe. What the
// pose is off as a whole, by the drift of the map, the keyframe is off, too.
constexpr double kSharpCells = 1;

bool IsOccupied(const Cell& cell) {
  return cell.log_odds >= kOccupiedFrom;
}

// x, y: in the tile; the window reaches kThinning cells beyond it.
CellState StateOf(const CellWindow& window, int x, int y) {
  const Cell& cell = window.at(x + kThinning, y + kThinning);
  if (cell.log_odds <= kFreeFrom) return CellState::kFree;
  if (!IsOccupied(cell)) return CellState::kUnknown;
  float sharpest = 0;
  for (int j = y; j <= y + 2 * kThinning; ++j) {
    for (int i = x; i <= x + 2 * kThinning; ++i) {
      const Cell& other = window.at(i, j);
      if (IsOccupied(other)) sharpest = std::max(sharpest, other.sharpness);
    }
  }
  return cell.sharpness >= kLeastSharpness * sharpest ? CellState::kOccupied : CellState::kUnknown;
}

}  // namespace

bool GridMap::IsOtherMap(const MapUpdate& update) const {
  if (length_factor_ && *length_factor_ != update.length_factor) return true;
  return std::any_of(update.keyframes.begin(), update.keyframes.end(), [this](const auto& k) {
    const auto known = keyframes_.find(k.id);
    if (known != keyframes_.end()) return known->second.utime != k.utime;
    const auto piece = pieces_.find(k.id);
    return piece != pieces_.end() && piece->second.keyframe_utime != Utime{} &&
           piece->second.keyframe_utime != k.utime;
  });
}

bool GridMap::Apply(const MapUpdate& update) {
  const bool other = IsOtherMap(update);
  if (other) {
    pieces_.clear();
    keyframes_.clear();
    removed_.clear();
    pieces_of_tile_.clear();
    dirty_.clear();
    tiles_.clear();
  }
  map_revision_ = update.revision;
  length_factor_ = update.length_factor;
  for (const KeyframeUpdate& keyframe : update.keyframes) {
    const Pose2 T_WK = BodyPose(keyframe.T_WC);
    keyframes_[keyframe.id] = {T_WK, keyframe.utime};
    if (const auto piece = pieces_.find(keyframe.id); piece != pieces_.end()) {
      piece->second.keyframe_utime = keyframe.utime;
      Place(keyframe.id, &piece->second, T_WK);
    }
  }
  for (const KeyframeRemoval& removal : update.removed_keyframes) Remove(removal);
  return other;
}

void GridMap::Remove(const KeyframeRemoval& removal) {
  const Pose2 T_ParentK(T_BC_ * removal.T_ParentC * T_BC_.inverse());
  removed_[removal.id] = {removal.parent, T_ParentK};
  keyframes_.erase(removal.id);
  const auto found = pieces_.find(removal.id);
  if (found == pieces_.end()) return;
  Detach(removal.id, &found->second);
  LocalGrid grid = std::move(found->second.grid);
  pieces_.erase(found);
  const Pose2 T_PL = T_ParentK * grid.T_KL;
  Piece& parent = pieces_[removal.parent];
  if (parent.grid.cells.tiles().empty()) {
    parent.grid = {T_PL, std::move(grid.cells)};
  } else {
    Detach(removal.parent, &parent);
    Merge(grid.cells, parent.grid.T_KL.inverse() * T_PL, cell_m_, &parent.grid.cells);
  }
  if (const auto keyframe = keyframes_.find(removal.parent); keyframe != keyframes_.end()) {
    parent.keyframe_utime = keyframe->second.utime;
    Place(removal.parent, &parent, keyframe->second.T_WK);
  }
}

void GridMap::Place(KeyframeId id, Piece* piece, const Pose2& T_WK) {
  const Pose2 T_WL = T_WK * piece->grid.T_KL;
  if (piece->T_WL) {
    const Pose2 moved = piece->T_WL->inverse() * T_WL;
    const double shift = moved.translation().norm() + std::abs(std::sin(moved.yaw())) * max_range_;
    if (shift < kMovedCells * cell_m_) return;
    ++counters_.grids_moved;
    Detach(id, piece);
  }
  piece->T_WL = T_WL;
  for (const auto& [tile, cells] : piece->grid.cells.tiles()) Touch(id, piece, tile);
}

// A tile of the piece changed: those of the sum under it have to be composed.
void GridMap::Touch(KeyframeId id, Piece* piece, Index2 local_tile) {
  for (const Index2 tile : TilesTouchedBy(local_tile, *piece->T_WL, cell_m_, kThinning)) {
    dirty_.insert(tile);
    if (piece->touched.insert(tile).second) pieces_of_tile_[tile].insert(id);
  }
}

void GridMap::Detach(KeyframeId id, Piece* piece) {
  for (const Index2 tile : piece->touched) {
    dirty_.insert(tile);
    pieces_of_tile_[tile].erase(id);
  }
  piece->touched.clear();
  piece->T_WL.reset();
}

bool GridMap::IsSharp(const FramePose& pose) const {
  const Matrix6d& cov = pose.motion_us > 0 ? pose.cov_motion : pose.cov_T_WB;
  const double position = std::sqrt(std::max(0.0, std::max(cov(0, 0), cov(1, 1))));
  const double heading = std::sqrt(std::max(0.0, cov(5, 5)));
  return position + heading * max_range_ / 2 <= kSharpCells * cell_m_;
}

bool GridMap::Add(const FramePose& pose, const FloorScan& scan) {
  const bool sees =
      pose.status == TrackingStatus::kTracking || pose.status == TrackingStatus::kDegraded;
  if (!sees || !pose.reference_keyframe.valid()) {
    ++counters_.blind;
    return false;
  }
  if (!IsSharp(pose)) {
    ++counters_.uncertain;
    return false;
  }
  KeyframeId id = pose.reference_keyframe;
  Pose2 T_KB(T_BC_ * pose.T_KC * T_BC_.inverse());
  for (auto gone = removed_.find(id); gone != removed_.end(); gone = removed_.find(id)) {
    T_KB = gone->second.T_ParentK * T_KB;
    id = gone->second.parent;
  }
  Piece& piece = pieces_[id];
  if (!piece.T_WL) {
    // A keyframe that the map does not have yet is where its image was.
    const auto known = keyframes_.find(id);
    const Pose2 T_WK =
        known != keyframes_.end() ? known->second.T_WK : Pose2(pose.T_WB) * T_KB.inverse();
    if (known != keyframes_.end()) piece.keyframe_utime = known->second.utime;
    if (piece.grid.cells.tiles().empty()) piece.grid = BeginLocalGrid(T_WK, cell_m_);
    Place(id, &piece, T_WK);
  }
  Index2 last_tile{};
  bool any = false;
  const Pose2 T_LB = piece.grid.T_KL.inverse() * T_KB;
  for (const CellEvidence& e : EvidenceOf(scan, T_LB, cell_m_, footprint_m_)) {
    piece.grid.cells.Add(e.index, e.cell);
    const Index2 tile = TileOf(e.index);
    if (any && tile == last_tile) continue;
    any = true;
    last_tile = tile;
    Touch(id, &piece, tile);
  }
  utime_ = std::max(utime_, pose.utime);
  ++counters_.scans;
  return true;
}

std::vector<GridTile> GridMap::Compose() {
  std::vector<GridTile> changed;
  if (dirty_.empty()) return changed;
  ++version_;
  for (const Index2 index : std::exchange(dirty_, {})) {
    ++counters_.tiles_composed;
    CellWindow sum({index.x * kTileSide - kThinning, index.y * kTileSide - kThinning},
                   kTileSide + 2 * kThinning);
    for (const KeyframeId id : pieces_of_tile_[index]) {
      const Piece& piece = pieces_.at(id);
      AddTo(&sum, piece.grid.cells, *piece.T_WL, cell_m_);
    }
    GridTile& tile = tiles_[index];
    GridTile fresh{index.x, index.y, tile.version, {}};
    for (int y = 0; y < kTileSide; ++y) {
      for (int x = 0; x < kTileSide; ++x) {
        fresh.cells[CellTiles::Offset({x, y})] = StateOf(sum, x, y);
      }
    }
    if (tile.version != 0 && fresh.cells == tile.cells) continue;
    fresh.version = version_;
    tile = fresh;
    changed.push_back(tile);
  }
  return changed;
}

std::vector<GridMap::SavedGrid> GridMap::Save() const {
  std::vector<SavedGrid> out;
  for (const auto& [id, piece] : pieces_) out.push_back({id, piece.keyframe_utime, piece.grid});
  return out;
}

void GridMap::Restore(std::vector<SavedGrid> grids) {
  for (SavedGrid& saved : grids) {
    Piece& piece = pieces_[saved.keyframe];
    piece.grid = std::move(saved.grid);
    piece.keyframe_utime = saved.keyframe_utime;
    if (const auto known = keyframes_.find(saved.keyframe); known != keyframes_.end()) {
      Place(saved.keyframe, &piece, known->second.T_WK);
    }
  }
}

}  // namespace gw::grid

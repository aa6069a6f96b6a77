// The front-end's replica of the map: what tracking needs of it, kept in step by MapUpdates. New
// keyframes enter at once (so that tracking goes on without the back-end) and are overwritten by
// what the back-end makes of them.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "common/core/id_table.h"
#include "common/vision/pyramid.h"

namespace gw::frontend {

struct MapPoint {
  LandmarkId id;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // unit, from the cameras to the point
  float min_distance = 0, max_distance = 0;            // m
  Descriptor descriptor{};
  std::vector<KeyframeId> observers;  // sorted
  uint64_t visit = 0;                 // mark of the newest CollectAround
};

class LocalMap {
 public:
  LocalMap(const RectifiedCamera& camera, const Pyramid& pyramid);
  // Its parts name each other by address.
  LocalMap(const LocalMap&) = delete;
  LocalMap& operator=(const LocalMap&) = delete;
  LocalMap(LocalMap&&) = default;
  LocalMap& operator=(LocalMap&&) = default;

  // Own keyframe, before the back-end has seen it. New landmarks are placed from its features'
  // depth.
  void AddKeyframe(const Keyframe& keyframe);

  // Returns false when the update does not follow the replica's revision (a gap): nothing is
  // changed, ask for a snapshot. Updates at or below the replica's revision are old news: true,
  // nothing changed.
  bool Apply(const MapUpdate& update);

  // Multiplies all lengths of the piece in use, around its first keyframe. The back-end does so,
  // with all pieces, when a keyframe tells it: until then it tells nothing of where things are that
  // is taken in, but for snapshots. Returns the center; empty: so is the piece.
  std::optional<Eigen::Vector3d> ScaleLengths(double by);
  // The factor of all lengths (Keyframe says which); that of the map that it began with.
  double length_factor() const { return length_factor_; }

  // A snapshot has come: what the back-end has is here.
  bool known() const { return known_; }
  // The back-end takes in no keyframes.
  bool frozen() const { return frozen_; }
  bool empty() const { return points_.empty(); }
  // There is something to track.
  bool there() const { return known_ && !empty(); }
  int64_t revision() const { return revision_; }
  size_t num_keyframes() const { return keyframes_.size(); }
  size_t num_points() const { return points_.size(); }
  KeyframeId newest_keyframe() const {
    return keyframes_.empty() ? KeyframeId{} : keyframes_.rbegin()->first;
  }

  const MapPoint* Find(LandmarkId id) const;
  // Where a camera at inv(T_CW) has the landmark, px; empty: out of view, or not there any more.
  std::optional<Eigen::Vector2d> PixelOf(LandmarkId id, const SE3& T_CW) const;
  // Landmarks that the keyframe sees; 0 when it is not there.
  int NumLandmarks(KeyframeId id) const;
  std::optional<SE3> KeyframePose(KeyframeId id) const;
  // The piece of the map that it belongs to; empty when it is not there.
  std::optional<KeyframeId> PieceOf(KeyframeId id) const;

  // The piece in which the camera is looked for (CollectNear): at first the map itself, an invalid
  // id. Poses of other pieces have nothing to do with its own.
  void Use(KeyframeId piece) { piece_ = piece; }
  KeyframeId piece() const { return piece_; }

  // The landmarks that the keyframes around the tracked ones see: the keyframes that share most
  // landmarks with `tracked`, `reference` always among them, at most max_keyframes. Every landmark
  // once, in a fixed order. best: the keyframe that shares most (reference when none does).
  void CollectAround(const std::vector<LandmarkId>& tracked, KeyframeId reference,
                     int max_keyframes, std::vector<const MapPoint*>* points, KeyframeId* best);

  // The landmarks of the keyframes of the piece in use that are nearest to a pose (m + rad) and see
  // any, at most max_keyframes: for coming back after a blind span or a restart. nearest: the first
  // of them, invalid when there is none.
  void CollectNear(const SE3& T_WC, int max_keyframes, std::vector<const MapPoint*>* points,
                   KeyframeId* nearest);

 private:
  // A landmark that a keyframe sees, or saw before it was gone.
  struct Seen {
    LandmarkId id;
    MapPoint* point = nullptr;  // where it was last; another one's, or nobody's, when it is gone
  };
  struct ReplicaKeyframe {
    SE3 T_WC;
    Utime utime;
    KeyframeId piece;
    std::vector<Seen> landmarks;
    int votes = 0;
  };

  // Without a look-up where it still is where it was. Null: it is gone.
  MapPoint* Find(const Seen& seen) {
    return seen.point != nullptr && seen.point->id == seen.id ? seen.point
                                                              : points_.Find(seen.id.value);
  }
  // Keyframes and landmarks, as the back-end has them.
  void TakePlaces(const MapUpdate& update);
  void Upsert(const LandmarkUpdate& update);
  void AppendLandmarksOf(KeyframeId id, std::vector<const MapPoint*>* points);
  void MovePending(const MapUpdate& update,
                   const std::map<KeyframeId, ReplicaKeyframe>& all_before);

  RectifiedCamera camera_;
  Pyramid pyramid_;
  bool known_ = false;
  bool frozen_ = false;
  int64_t revision_ = 0;
  uint64_t visit_ = 0;
  KeyframeId piece_;
  double length_factor_ = 1;
  std::map<KeyframeId, ReplicaKeyframe> keyframes_;
  IdTable<MapPoint> points_;  // by LandmarkId::value
};

}  // namespace gw::frontend

// The map: keyframes, landmarks, and what follows from them (covisibility, the DR chain).
//
// One form of change: everything that a mapper does to its map between two commits is described by
// one MapUpdate, and a map that gets the same keyframes and updates in the same order is equal to
// the mapper's (Hash() agrees). Replica and journal rely on it.
//
// Keyframe poses are T_WC of the rectified left camera; landmarks are points in W (m).
// Copyable value; not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/contract/map.h"
#include "common/core/id_table.h"
#include "common/vision/feature_grid.h"

namespace gw::backend {

using Landmark = LandmarkUpdate;  // the contract's complete state of a landmark

struct MapKeyframe {
  // As inserted, but kept current: T_WC is the best pose, `landmarks` the present observations,
  // `previous` and `dr` the temporal chain after culled keyframes were bridged.
  Keyframe frame;
  FeatureGrid grid;
  KeyframeId next;               // the keyframe whose `previous` this is
  double dr_alpha = 0;           // scale of the DR information from `previous`; 0 = none yet
  int32_t num_observations = 0;  // landmarks it observes
  // The landmarks that it observes and with which feature, sorted by landmark: what
  // `frame.landmarks` says, in the order in which two keyframes can be compared.
  std::vector<std::pair<LandmarkId, int32_t>> seen;
  // Keyframes that share landmarks with this one, and how many; sorted by id.
  std::vector<std::pair<KeyframeId, int32_t>> covisible;
};

class Map {
 public:
  int64_t revision() const { return revision_; }
  KeyframeId newest_keyframe() const { return newest_keyframe_; }
  Utime newest_utime() const { return newest_utime_; }
  const std::map<KeyframeId, MapKeyframe>& keyframes() const { return keyframes_; }
  double length_factor() const { return length_factor_; }
  size_t num_landmarks() const { return landmarks_.size(); }

  // Null when there is none. Valid until the element is removed.
  const MapKeyframe* FindKeyframe(KeyframeId id) const;
  const Landmark* FindLandmark(LandmarkId id) const;
  std::vector<LandmarkId> SortedLandmarkIds() const;

  // The landmark that `id` stands for today: itself, or what it was merged into; invalid when gone.
  LandmarkId Resolve(LandmarkId id) const;
  // Where a removed keyframe's pose lives on; the parent is in the map. Empty when unknown.
  std::optional<KeyframeRemoval> FindRemoval(KeyframeId id) const;
  // Landmarks that both keyframes observe.
  int SharedLandmarks(KeyframeId a, KeyframeId b) const;
  // Keyframes sharing at least min_shared landmarks with `id`: most first, then newest first.
  std::vector<std::pair<KeyframeId, int32_t>> Neighbours(KeyframeId id, int min_shared) const;
  // The piece that a keyframe belongs to. Precondition: it is in the map. Landmarks belong to the
  // piece of their observers, which is one: pieces share nothing until they are joined.
  KeyframeId PieceOf(KeyframeId id) const { return keyframes_.at(id).frame.piece; }
  // The pieces there are, the map itself (an invalid id) first, if it has keyframes, and the first
  // keyframe of each: the oldest that is still there, which holds its piece in place where nothing
  // else does. (The one that named the piece may have been culled or cropped away.)
  std::map<KeyframeId, KeyframeId> FirstOfPieces() const;
  // Are there several?
  bool IsInPieces() const;

  // --- Changes by the mapper. Each is part of the update that the next Commit() returns.

  // False, and no change, when the id is not newer than every keyframe so far, the time not after
  // that of `previous`, or CheckKeyframe() finds a fault. The pose is taken from the keyframe, its
  // `landmarks` are not: observations are added one by one. A `previous` that is not in the map, or
  // that another keyframe follows already, leaves the new one without a temporal edge; with one, it
  // belongs to the piece of `previous`, which may have been joined to another one meanwhile. One
  // that withdraws others takes them out first; one that tells another factor of lengths corrects
  // those of the map (SetLengthFactor).
  bool AddKeyframe(const Keyframe& keyframe);
  // Preconditions of the following: the ids exist, unless stated otherwise.
  void SetPose(KeyframeId id, const SE3& T_WC);
  // Puts the frame of the piece `from` at T_IntoFrom in that of the piece `into`, of which it then
  // is a part. Precondition: `from` is valid and not `into`.
  void JoinPiece(KeyframeId from, KeyframeId into, const SE3& T_IntoFrom);
  // All lengths that the camera has told are from now on multiplied by this instead of
  // length_factor(): positions, around that of the first keyframe of each piece, distances of
  // landmarks, and depths of features. DR's ways are not the camera's. Precondition: > 0.
  void SetLengthFactor(double factor);
  // Adds a landmark without observations. Precondition: the id is not in the map.
  Landmark& AddLandmark(LandmarkId id);
  // For changing a landmark's geometry and descriptor (not id and observations).
  Landmark& MutableLandmark(LandmarkId id);
  // False when the feature is taken, does not exist, or the keyframe already observes the landmark.
  bool AddObservation(LandmarkId id, const Observation& observation);
  void RemoveObservation(LandmarkId id, KeyframeId keyframe);
  // Observations of `from` that `into` does not have yet move over; `from` is gone.
  void MergeLandmark(LandmarkId from, LandmarkId into);
  // The id need not exist: the receiver may have it although we never took it in.
  void RemoveLandmark(LandmarkId id);
  // Bridges the DR chain over it; the pose lives on relative to `parent`.
  void RemoveKeyframe(KeyframeId id, KeyframeId parent);
  void SetDrAlpha(KeyframeId to, double alpha);

  // The changes since the last commit (or Apply); counts the revision up by one.
  MapUpdate Commit();

  // Those that left since the last Commit().
  const std::vector<KeyframeRemoval>& removed_keyframes() const {
    return changes_.removed_keyframes;
  }

  // --- Changes by a receiver.

  enum class Applied { kDone, kGap };
  // kGap, and no change: the update is not a snapshot and its base is not our revision. Parts that
  // contradict themselves or the map (unknown ids, NaN, a feature that another landmark has) are
  // left out and counted in num_ignored(): whatever the update says, the map holds together.
  Applied Apply(const MapUpdate& update);
  int64_t num_ignored() const { return num_ignored_; }

  // The whole state as one update (snapshot = true, our revision). With the keyframes themselves
  // added first, applying it to an empty map gives an equal one.
  MapUpdate Snapshot() const;

  // FNV-1a over the whole state in sorted order; equal maps have equal hashes.
  uint64_t Hash() const;

 private:
  MapKeyframe* MutableKeyframe(KeyframeId id);
  // Takes out the keyframes between `sound`, which is in the map, and `until`, with the landmarks
  // that they made, or alone observe.
  void Withdraw(KeyframeId sound, KeyframeId until);
  // Landmark and keyframe name each other from now on. False, and no change, when the keyframe is
  // unknown, its feature taken or not there, or the landmark observed by it already.
  bool Link(Landmark& landmark, const Observation& observation);
  void Unlink(Landmark& landmark, size_t which);  // of its observations
  // The keyframe shares the landmark with its other observers, or (delta = -1) no longer does.
  void Share(const Landmark& landmark, KeyframeId keyframe, int32_t delta);
  void EraseLandmark(LandmarkId id);
  void EraseKeyframe(KeyframeId id);
  void RecordMerge(LandmarkId from, LandmarkId into);
  void RecordRemoval(const KeyframeRemoval& removal);

  // Parts of Apply(). False: the part contradicts the map, and is left out.
  void ClearFor(const MapUpdate& snapshot);
  bool IsUsable(const LandmarkUpdate& update) const;
  bool MovesWholePieces(const MapUpdate& update) const;
  bool TakePose(const KeyframeUpdate& update, bool whole_pieces);
  void DropUnlistedObservations(const LandmarkUpdate& update);
  bool TakeLandmark(const LandmarkUpdate& update, bool snapshot);
  void CountCovisibility();
  bool TakeRemoval(const KeyframeRemoval& removal, bool snapshot);
  bool TakeDrWeight(const DrEdgeWeight& edge);

  std::map<KeyframeId, MapKeyframe> keyframes_;
  IdTable<Landmark> landmarks_;  // by LandmarkId::value; iterated where order does not matter
  // Bounded histories: the entries with the oldest ids go first.
  std::map<LandmarkId, LandmarkId> merged_into_;
  std::map<KeyframeId, KeyframeRemoval> removals_;
  int64_t revision_ = 0;
  KeyframeId newest_keyframe_;
  Utime newest_utime_;
  double length_factor_ = 1;
  int64_t num_ignored_ = 0;

  struct Changes {
    std::set<KeyframeId> keyframes;
    std::vector<KeyframeRemoval> removed_keyframes;
    std::vector<LandmarkId> landmarks;  // with repetitions
    std::vector<LandmarkMerge> merged;
    std::vector<LandmarkId> removed;
    std::set<KeyframeId> dr_edges;  // named by their later keyframe
  };
  Changes changes_;
};

// The motion a -> c from those a -> b and b -> c; covariances add (as if independent).
DrIncrement Compose(const DrIncrement& ab, const DrIncrement& bc);

}  // namespace gw::backend

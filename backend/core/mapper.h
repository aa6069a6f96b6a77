// Local mapping: takes keyframes in, keeps the map small and accurate, and says what changed.
//
//   Insert(keyframe)            at once: the update that takes it in
//   BuildJob() -> SolveLocalBa  local bundle adjustment; Solve may run on another thread, while
//   Apply(result)               further keyframes are inserted
//   CloseLoop() -> SolveLoopGraph   after an insertion: the same for a loop, when there is one
//   Apply(result)
//   BuildGlobalJob() -> SolveLocalBa, ApplyGlobal(result)   after a loop was closed, and when due
//
// Every change of the map is one MapUpdate with the next revision. Keyframes come from another
// process: whatever they hold is rejected and counted, never trusted. Single-threaded, no clocks;
// the same calls give the same bytes.
#pragma once

#include <deque>
#include <optional>

#include "backend/core/bundle/local_ba.h"
#include "backend/core/loop/loop_closer.h"
#include "backend/core/map/keyframe_check.h"
#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"
#include "backend/core/piece/piece_join.h"
#include "common/contract/place.h"
#include "common/core/result.h"

namespace gw::backend {

// Since Create.
struct MapperCounters {
  int64_t keyframes_inserted = 0;
  int64_t keyframes_duplicate = 0;  // id not newer than the map's: a resend
  int64_t keyframes_rejected = 0;   // see InsertResult::reason
  int64_t keyframes_culled = 0;
  int64_t keyframes_withdrawn = 0;  // by a later one: they did not show the world
  int64_t observations_accepted = 0;
  int64_t observations_unknown = 0;    // of landmarks that the map does not have (any more)
  int64_t observations_repeated = 0;   // the keyframe observes that landmark already
  int64_t observations_found = 0;      // that tracking missed and fusion found
  int64_t landmarks_invalid = 0;       // created by the front-end without usable depth or name
  int64_t landmarks_created = 0;       // by front-end and back-end
  int64_t landmarks_triangulated = 0;  // of these, by the back-end from two views
  int64_t landmarks_merged = 0;
  int64_t landmarks_culled = 0;
  int64_t dr_rejected = 0;  // increments that are not usable as an edge
  int64_t local_ba_applied = 0;
  int64_t local_ba_stale = 0;  // the map was changed under the job
  int64_t local_ba_failed = 0;
  int64_t global_ba_applied = 0;
  int64_t global_ba_stale = 0;  // a loop was closed meanwhile
  int64_t global_ba_failed = 0;
  int64_t pieces_joined = 0;
};

enum class MapUse {
  kGrow,
  kFrozen,  // localise only: the map never changes
};

struct InsertResult {
  enum class Status {
    kInserted,   // `update` is set
    kDuplicate,  // already in the map (or older than its newest): acknowledge it again
    kRejected,   // cannot be used; `reason` says why. Acknowledge it too: a resend will not help
    kFrozen,     // the map takes nothing in: acknowledge it
  };
  Status status = Status::kRejected;
  const char* reason = "";
  std::optional<MapUpdate> update;
};

class Mapper {
 public:
  // `map`: to go on with, for example from the journal. Error: kBadConfig.
  static Result<Mapper> Create(const BackendConfig& config, const FrontendConfig& frontend,
                               const RectifiedCamera& camera, Map map = {},
                               MapUse use = MapUse::kGrow);

  InsertResult Insert(const Keyframe& keyframe);

  // Empty while there is nothing to optimise (fewer than two keyframes, or frozen).
  std::optional<LocalBaJob> BuildJob() const;
  // Empty when the result is stale or not usable (counted).
  std::optional<MapUpdate> Apply(const LocalBaResult& result);

  // Empty when the newest keyframe closes no loop.
  std::optional<LoopGraphJob> CloseLoop() { return CloseLoopAt(map_.newest_keyframe()); }
  // The same for another keyframe, to an older one: in maps that were put together.
  std::optional<LoopGraphJob> CloseLoopAt(KeyframeId keyframe);
  // Pieces of the map (docs/adr/0047-pieces-of-a-map.md) are joined when a new keyframe shows, with
  // those before it, how they lie to each other: Insert() asks, and its update tells. In maps that
  // were put together it can be asked of other keyframes, and be told.
  std::optional<PieceSight> SeeElsewhere(KeyframeId keyframe) const {
    return backend::SeeElsewhere(map_, context_, loops_.places(), keyframe);
  }
  MapUpdate Join(const PieceJoin& join);
  // Empty when the graph was not solved, or showed the loop to be wrong and changed nothing else.
  std::optional<MapUpdate> Apply(const LoopGraphResult& result);

  // True when a good part of the map came in since the last global job, and the newest keyframe
  // sees what was mapped long before it: there the map holds itself, and what was driven again
  // makes it better. (A chain that is still open has nothing to gain: docs/adr/0015.) A map to go
  // on with counts as new: its last global job may have died with the process.
  bool GlobalBaDue() const;
  // The whole map; its result goes to ApplyGlobal.
  std::optional<LocalBaJob> BuildGlobalJob();
  // Empty when a loop was closed since the job was cut, or the result is not usable (counted).
  std::optional<MapUpdate> ApplyGlobal(const LocalBaResult& result);

  // Answers a PlaceQuery. Does not change the map.
  PlaceMatch Locate(const PlaceQuery& query) const;

  // Answers a MapRequest: the whole map, or with a guess at most kSnapshotKeyframes keyframes
  // nearest to it and the landmarks they observe. Does not change the revision.
  static constexpr size_t kSnapshotKeyframes = 200;
  MapUpdate Snapshot(const std::optional<SE3>& T_WC_near) const;

  const Map& map() const { return map_; }
  const MapperCounters& counters() const { return counters_; }
  const LoopCounters& loop_counters() const { return loops_.counters(); }

 private:
  Mapper(const MappingContext& context, Map map, MapUse use);

  SE3 CarriedPose(const Keyframe& keyframe) const;
  void TakeObservations(const Keyframe& keyframe);
  void CarryAlong(const LocalBaResult& result);
  void TakeOver(const LocalBaResult& result);
  void ForgetRemoved();
  MapUpdate Commit();

  MappingContext context_;
  Map map_;
  MapUse use_;
  LoopCloser loops_;
  PieceJoiner joiner_;
  MapperCounters counters_;
  int64_t inserted_since_global_;     // keyframes
  int64_t poses_moved_revision_ = 0;  // the last one in which keyframes moved
  int64_t loop_revision_ = 0;         // the last one in which a loop was closed, or pieces joined
  // Since the last global job. Loop graphs cut before hold poses of the frames before.
  bool joined_ = false;
  KeyframeId newest_at_join_;

  // Where keyframes were before they moved, newest last: a keyframe that was tracked in an older
  // map follows its predecessor's move. Bounded.
  struct Move {
    int64_t revision = 0;
    KeyframeId id;
    SE3 T_WC_before;
  };
  std::deque<Move> moves_;
  void RememberMove(int64_t revision, KeyframeId id, const SE3& T_WC_before);
};

}  // namespace gw::backend

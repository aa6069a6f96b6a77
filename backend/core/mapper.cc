#include "backend/core/mapper.h"

#include <algorithm>
#include <cstdlib>
#include <map>

#include "backend/core/bundle/window.h"
#include "backend/core/loop/locate.h"
#include "backend/core/mapping/culling.h"
#include "backend/core/mapping/fusion.h"
#include "backend/core/mapping/landmark_state.h"
#include "backend/core/mapping/triangulation.h"

namespace gw::backend {
namespace {

constexpr size_t kMaxMoves = 2000;  // more than a second's worth of local windows

// Global BA is due again when so many keyframes, and such a part of all, came in since the last. A
// part, so that what it costs per keyframe does not grow with the map.
constexpr int64_t kLeastRenewed = 40;
constexpr int64_t kRenewedPart = 8;  // one in so many
// What a keyframe that old saw is known ground.
constexpr DurationUs kLongAgo = Milliseconds(30000);

// What is observed from another piece of the map belongs to that.
bool LiesIn(const Map& map, LandmarkId id, KeyframeId piece) {
  const std::vector<Observation>& observations = map.FindLandmark(id)->observations;
  return observations.empty() || map.PieceOf(observations.front().keyframe) == piece;
}

bool SeesKnownGround(const Map& map, int least_shared) {
  const MapKeyframe* newest = map.FindKeyframe(map.newest_keyframe());
  if (newest == nullptr) return false;
  const auto neighbours = map.Neighbours(newest->frame.id, least_shared);
  return std::any_of(neighbours.begin(), neighbours.end(), [&](const auto& neighbour) {
    // Another session may have another clock.
    const DurationUs age = newest->frame.utime - map.FindKeyframe(neighbour.first)->frame.utime;
    return std::abs(age.us) > kLongAgo.us;
  });
}

}  // namespace

Result<Mapper> Mapper::Create(const BackendConfig& config, const FrontendConfig& frontend,
                              const RectifiedCamera& camera, Map map, MapUse use) {
  if (!(camera.fx > 0 && camera.fy > 0 && camera.baseline_m > 0 && camera.depth_max_m > 0)) {
    return Error{ErrorCode::kBadConfig,
                 "calibration.camera: focal length, baseline and depth_max_m must be > 0"};
  }
  if (frontend.orb.num_levels < 1 || frontend.orb.num_levels > kMaxLevel ||
      !(frontend.orb.scale_factor > 1)) {
    return Error{ErrorCode::kBadConfig,
                 "frontend.orb: num_levels must be 1..31 and scale_factor > 1"};
  }
  if (!(frontend.dr_weight.alpha_min > 0) ||
      !(frontend.dr_weight.alpha_max >= frontend.dr_weight.alpha_min)) {
    return Error{ErrorCode::kBadConfig,
                 "frontend.dr_weight: alpha_min must be > 0 and alpha_max >= alpha_min"};
  }
  return Mapper(MappingContext(config, frontend, camera), std::move(map), use);
}

Mapper::Mapper(const MappingContext& context, Map map, MapUse use)
    : context_(context),
      map_(std::move(map)),
      use_(use),
      loops_(map_),
      inserted_since_global_(std::ssize(map_.keyframes())) {}

// What left the map is no place any more.
void Mapper::ForgetRemoved() {
  for (const KeyframeRemoval& removal : map_.removed_keyframes()) loops_.Forget(removal.id);
}

MapUpdate Mapper::Commit() {
  ForgetRemoved();
  return map_.Commit();
}

void Mapper::RememberMove(int64_t revision, KeyframeId id, const SE3& T_WC_before) {
  moves_.push_back({revision, id, T_WC_before});
  if (moves_.size() > kMaxMoves) moves_.pop_front();
}

// The pose in today's map of a keyframe that was tracked in an older one.
SE3 Mapper::CarriedPose(const Keyframe& keyframe) const {
  const MapKeyframe* previous = map_.FindKeyframe(keyframe.previous);
  if (previous == nullptr) return keyframe.T_WC;
  const auto first = std::find_if(moves_.begin(), moves_.end(), [&](const Move& move) {
    return move.revision > keyframe.map_revision && move.id == keyframe.previous;
  });
  if (first == moves_.end()) return keyframe.T_WC;
  return previous->frame.T_WC * first->T_WC_before.inverse() * keyframe.T_WC;
}

void Mapper::TakeObservations(const Keyframe& keyframe) {
  const SE3 T_WC = map_.FindKeyframe(keyframe.id)->frame.T_WC;
  for (size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId named = keyframe.landmarks[i];
    if (!named.valid()) continue;
    const Observation observation{keyframe.id, static_cast<int32_t>(i)};
    const Feature& f = keyframe.features[i];
    LandmarkId id = named;
    if (named.creator() == keyframe.id) {
      if (named.feature_index() != static_cast<int>(i) || !f.has_depth()) {
        ++counters_.landmarks_invalid;
        map_.RemoveLandmark(named);
        continue;
      }
      map_.AddLandmark(id).p_W = T_WC * context_.camera.Unproject(f.u, f.v, f.depth);
      ++counters_.landmarks_created;
    } else {
      id = map_.Resolve(named);
      if (id.valid() && !LiesIn(map_, id, map_.PieceOf(keyframe.id))) {
        ++counters_.observations_unknown;
        continue;
      }
      if (!id.valid()) {
        ++counters_.observations_unknown;
        map_.RemoveLandmark(named);  // whoever still has it learns that it is gone
        continue;
      }
    }
    if (!map_.AddObservation(id, observation)) {
      ++counters_.observations_repeated;
      continue;
    }
    ++counters_.observations_accepted;
    RefreshGeometry(map_, context_, id);
    RefreshDescriptor(map_, id);
  }
}

InsertResult Mapper::Insert(const Keyframe& keyframe) {
  InsertResult out;
  if (use_ == MapUse::kFrozen) {
    out.status = InsertResult::Status::kFrozen;
    return out;
  }
  const MapKeyframe* previous = map_.FindKeyframe(keyframe.previous);
  const KeyframeFault fault = CheckKeyframe(keyframe);
  if (fault != KeyframeFault::kNone) {
    out.reason = KeyframeFaultText(fault);
  } else if (keyframe.id <= map_.newest_keyframe()) {
    ++counters_.keyframes_duplicate;
    out.status = InsertResult::Status::kDuplicate;
    return out;
  } else if (previous != nullptr && keyframe.utime <= previous->frame.utime) {
    // Only along the chain: another session may have another clock, or come from an older log.
    out.reason = "time is not after that of the keyframe before it";
  }
  if (*out.reason != '\0') {
    ++counters_.keyframes_rejected;
    return out;
  }

  Keyframe usable = keyframe;
  if (usable.dr && !IsUsable(*usable.dr, usable.utime))
    ++counters_.dr_rejected;  // the map drops it
  usable.T_WC = CarriedPose(keyframe);
  const bool other_lengths = keyframe.length_factor != map_.length_factor();
  map_.AddKeyframe(usable);
  ForgetRemoved();  // those that it withdraws
  loops_.File(usable);
  TakeObservations(usable);
  counters_.landmarks_culled += CullYoungLandmarks(map_, context_);
  const int triangulated = TriangulateNewLandmarks(map_, context_);
  counters_.landmarks_triangulated += triangulated;
  counters_.landmarks_created += triangulated;
  const FusionCounts fused = FuseWithNeighbours(map_, context_);
  counters_.landmarks_merged += fused.merged;
  counters_.observations_found += fused.observations;

  RememberMove(map_.revision() + 1, keyframe.id, keyframe.T_WC);
  std::optional<PieceJoin> join;
  if (map_.IsInPieces()) {
    join = joiner_.Consider(map_, context_, loops_.places(), keyframe.id);
  }
  out.update = join ? Join(*join) : Commit();
  counters_.keyframes_withdrawn += std::ssize(out.update->removed_keyframes);
  if (other_lengths || !out.update->removed_keyframes.empty()) {
    poses_moved_revision_ = loop_revision_ = out.update->revision;  // of jobs cut before
  }
  ++counters_.keyframes_inserted;
  ++inserted_since_global_;
  out.status = InsertResult::Status::kInserted;
  return out;
}

std::optional<LocalBaJob> Mapper::BuildJob() const {
  if (use_ == MapUse::kFrozen) return std::nullopt;
  return CutLocalWindow(map_, context_);
}

// Moves what the result does not name but what hangs on it: keyframes newer than the job follow
// their predecessor, and landmarks that only moved keyframes see follow their first observer.
void Mapper::CarryAlong(const LocalBaResult& result) {
  std::map<KeyframeId, SE3> shift;  // W before -> W after, at each moved keyframe
  for (const auto& moved : result.keyframes) {
    const MapKeyframe* keyframe = map_.FindKeyframe(moved.id);
    if (keyframe != nullptr) shift[moved.id] = moved.T_WC * keyframe->frame.T_WC.inverse();
  }
  for (auto it = map_.keyframes().upper_bound(result.newest); it != map_.keyframes().end(); ++it) {
    const auto before = shift.find(it->second.frame.previous);
    if (before != shift.end()) shift[it->first] = before->second;
  }
  std::vector<LandmarkId> seen;
  for (const auto& [id, T] : shift) {
    for (const LandmarkId landmark : map_.FindKeyframe(id)->frame.landmarks) {
      if (landmark.valid()) seen.push_back(landmark);
    }
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  for (const LandmarkId id : seen) {
    const bool solved = std::binary_search(
        result.landmarks.begin(), result.landmarks.end(), LocalBaResult::MovedLandmark{id, {}},
        [](const auto& a, const auto& b) { return a.id < b.id; });
    if (solved) continue;
    const Landmark& landmark = *map_.FindLandmark(id);
    const bool hangs =
        std::all_of(landmark.observations.begin(), landmark.observations.end(),
                    [&](const Observation& o) { return shift.contains(o.keyframe); });
    if (!hangs) continue;
    const auto creator = shift.find(id.creator());
    const SE3& T =
        creator != shift.end() ? creator->second : shift.at(landmark.observations.front().keyframe);
    const Eigen::Vector3d p_W = T * landmark.p_W;
    map_.MutableLandmark(id).p_W = p_W;
    RefreshGeometry(map_, context_, id);
  }
  const int64_t revision = map_.revision() + 1;
  for (const auto& [id, T] : shift) {
    const SE3 before = map_.FindKeyframe(id)->frame.T_WC;
    RememberMove(revision, id, before);
    map_.SetPose(id, T * before);
  }
}

std::optional<MapUpdate> Mapper::Apply(const LocalBaResult& result) {
  if (!result.usable) {
    ++counters_.local_ba_failed;
    return std::nullopt;
  }
  if (result.revision < poses_moved_revision_) {
    ++counters_.local_ba_stale;
    return std::nullopt;
  }
  TakeOver(result);
  ++counters_.local_ba_applied;
  MapUpdate update = Commit();
  poses_moved_revision_ = update.revision;
  return update;
}

void Mapper::TakeOver(const LocalBaResult& result) {
  CarryAlong(result);
  for (const auto& moved : result.landmarks) {
    if (map_.FindLandmark(moved.id) != nullptr) map_.MutableLandmark(moved.id).p_W = moved.p_W;
  }
  for (const auto& outlier : result.outliers) {
    if (map_.FindLandmark(outlier.landmark) == nullptr ||
        map_.FindKeyframe(outlier.keyframe) == nullptr) {
      continue;
    }
    map_.RemoveObservation(outlier.landmark, outlier.keyframe);
    if (map_.FindLandmark(outlier.landmark)->observations.size() < 2) {
      map_.RemoveLandmark(outlier.landmark);
      ++counters_.landmarks_culled;
    }
  }
  for (const auto& moved : result.landmarks) {
    if (map_.FindLandmark(moved.id) != nullptr) RefreshGeometry(map_, context_, moved.id);
  }
  for (const DrEdgeWeight& edge : result.dr_edges) {
    const MapKeyframe* to = map_.FindKeyframe(edge.to);
    if (to != nullptr && to->frame.previous == edge.from) map_.SetDrAlpha(edge.to, edge.alpha);
  }
  counters_.keyframes_culled += CullRedundantKeyframes(map_, context_);
}

// Moves one piece into the frame of the other, and fuses what both mapped where they meet.
MapUpdate Mapper::Join(const PieceJoin& join) {
  for (const auto& [id, in_map] : map_.keyframes()) {
    if (in_map.frame.piece == join.from) RememberMove(map_.revision() + 1, id, in_map.frame.T_WC);
  }
  map_.JoinPiece(join.from, join.into, join.T_IntoFrom);
  for (const PieceSight& sight : join.sights) {
    std::vector<std::pair<int32_t, LandmarkId>> matches;
    for (const auto& match : sight.matches) matches.emplace_back(match.feature, match.landmark);
    FuseMatches(map_, context_, sight.keyframe, matches);
    FuseGroups(map_, context_, PlaceGroup(map_, sight.keyframe), PlaceGroup(map_, sight.place));
  }
  ++counters_.pieces_joined;
  MapUpdate update = Commit();
  const PieceSight& newest = join.sights.back();
  update.loops.push_back({newest.keyframe, newest.place, true, join.T_IntoFrom});
  poses_moved_revision_ = loop_revision_ = update.revision;
  joined_ = true;
  newest_at_join_ = map_.newest_keyframe();
  return update;
}

std::optional<LoopGraphJob> Mapper::CloseLoopAt(KeyframeId keyframe) {
  const auto loop = loops_.Detect(map_, context_, keyframe);
  if (!loop) return std::nullopt;
  return loops_.CutGraph(map_, context_, *loop);
}

std::optional<MapUpdate> Mapper::Apply(const LoopGraphResult& result) {
  if (!result.graph.usable || result.newest < newest_at_join_) return std::nullopt;
  const auto kept =
      std::count(result.graph.group_kept.begin(), result.graph.group_kept.end(), uint8_t{1});
  if (!result.closed() && kept + 1 == std::ssize(result.loops)) {
    loops_.Settle(map_, context_, result);  // only counts
    return std::nullopt;
  }
  // Corrections, not poses: what local BA did meanwhile stays.
  LocalBaResult moved;
  moved.newest = result.newest;
  for (size_t i = 0; i < result.ids.size(); ++i) {
    const MapKeyframe* keyframe = map_.FindKeyframe(result.ids[i]);
    if (keyframe == nullptr) continue;
    moved.keyframes.push_back({result.ids[i], result.T_correction[i] * keyframe->frame.T_WC});
  }
  LoopEvent event{result.loops.back().newer, result.loops.back().older, result.closed(), {}};
  const auto at = std::lower_bound(result.ids.begin(), result.ids.end(), event.from);
  event.T_correction = result.T_correction[static_cast<size_t>(at - result.ids.begin())];
  CarryAlong(moved);
  loops_.Settle(map_, context_, result);
  MapUpdate update = Commit();
  update.loops.push_back(event);
  poses_moved_revision_ = loop_revision_ = update.revision;
  return update;
}

bool Mapper::GlobalBaDue() const {
  if (joined_) return true;
  if (!context_.dr_weight.Departs(Departure::kRepeatedGlobalBa)) return false;
  const int64_t enough = std::max(kLeastRenewed, std::ssize(map_.keyframes()) / kRenewedPart);
  return inserted_since_global_ >= enough &&
         SeesKnownGround(map_, context_.config.covisibility_min_shared);
}

std::optional<LocalBaJob> Mapper::BuildGlobalJob() {
  inserted_since_global_ = 0;
  joined_ = false;
  return CutWholeMap(map_, context_);
}

std::optional<MapUpdate> Mapper::ApplyGlobal(const LocalBaResult& result) {
  if (result.revision < loop_revision_) {
    ++counters_.global_ba_stale;
    return std::nullopt;
  }
  if (!result.usable) {
    ++counters_.global_ba_failed;
    return std::nullopt;
  }
  TakeOver(result);
  ++counters_.global_ba_applied;
  MapUpdate update = Commit();
  poses_moved_revision_ = update.revision;
  return update;
}

PlaceMatch Mapper::Locate(const PlaceQuery& query) const {
  return backend::Locate(map_, context_, loops_.places(), query);
}

MapUpdate Mapper::Snapshot(const std::optional<SE3>& T_WC_near) const {
  MapUpdate whole = map_.Snapshot();
  whole.frozen = use_ == MapUse::kFrozen;
  if (!T_WC_near || whole.keyframes.size() <= kSnapshotKeyframes) return whole;
  std::vector<std::pair<double, KeyframeId>> by_distance;
  for (const auto& [id, keyframe] : map_.keyframes()) {
    const Eigen::Vector3d d = keyframe.frame.T_WC.translation() - T_WC_near->translation();
    by_distance.push_back({d.squaredNorm(), id});
  }
  std::sort(by_distance.begin(), by_distance.end());
  by_distance.resize(kSnapshotKeyframes);
  std::set<KeyframeId> chosen;
  for (const auto& [distance, id] : by_distance) chosen.insert(id);

  MapUpdate out = std::move(whole);
  std::erase_if(out.keyframes, [&](const auto& k) { return !chosen.contains(k.id); });
  std::erase_if(out.dr_edges,
                [&](const auto& e) { return !chosen.contains(e.from) || !chosen.contains(e.to); });
  std::erase_if(out.removed_keyframes, [&](const auto& r) { return !chosen.contains(r.parent); });
  for (LandmarkUpdate& landmark : out.landmarks) {
    std::erase_if(landmark.observations,
                  [&](const auto& o) { return !chosen.contains(o.keyframe); });
  }
  std::erase_if(out.landmarks, [](const auto& l) { return l.observations.empty(); });
  return out;
}

}  // namespace gw::backend

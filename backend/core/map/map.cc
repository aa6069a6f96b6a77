#include "backend/core/map/map.h"

#include <algorithm>
#include <utility>

#include "backend/core/map/keyframe_check.h"
#include "common/core/check.h"
#include "common/vision/scale_lengths.h"

namespace gw::backend {
namespace {

// Histories answer for keyframes that are on their way, so minutes would do; these last for hours.
constexpr size_t kMaxMerges = 1 << 16;
constexpr size_t kMaxRemovals = 1 << 14;

bool ById(const std::pair<KeyframeId, int32_t>& a, KeyframeId b) {
  return a.first < b;
}

void Adjust(std::vector<std::pair<KeyframeId, int32_t>>& covisible, KeyframeId other,
            int32_t delta) {
  const auto it = std::lower_bound(covisible.begin(), covisible.end(), other, ById);
  if (it == covisible.end() || it->first != other) {
    covisible.insert(it, {other, delta});
  } else if ((it->second += delta) == 0) {
    covisible.erase(it);
  }
}

bool Before(const Observation& a, KeyframeId b) {
  return a.keyframe < b;
}

auto PlaceIn(std::vector<std::pair<LandmarkId, int32_t>>& seen, LandmarkId id) {
  return std::lower_bound(seen.begin(), seen.end(), id,
                          [](const auto& entry, LandmarkId other) { return entry.first < other; });
}

}  // namespace

DrIncrement Compose(const DrIncrement& ab, const DrIncrement& bc) {
  DrIncrement out;
  out.utime_begin = ab.utime_begin;
  out.utime_end = bc.utime_end;
  out.T_BaBb = ab.T_BaBb * bc.T_BaBb;
  const Matrix6d adj = bc.T_BaBb.inverse().Adjoint();
  out.cov = adj * ab.cov * adj.transpose() + bc.cov;
  out.reset_counter = bc.reset_counter;
  out.slip = ab.slip || bc.slip;
  out.synthetic = ab.synthetic || bc.synthetic;
  return out;
}

const MapKeyframe* Map::FindKeyframe(KeyframeId id) const {
  const auto it = keyframes_.find(id);
  return it == keyframes_.end() ? nullptr : &it->second;
}

MapKeyframe* Map::MutableKeyframe(KeyframeId id) {
  const auto it = keyframes_.find(id);
  return it == keyframes_.end() ? nullptr : &it->second;
}

const Landmark* Map::FindLandmark(LandmarkId id) const {
  return landmarks_.Find(id.value);
}

std::vector<LandmarkId> Map::SortedLandmarkIds() const {
  std::vector<LandmarkId> ids;
  ids.reserve(landmarks_.size());
  landmarks_.ForEach([&](int64_t id, const Landmark&) { ids.push_back({id}); });
  std::sort(ids.begin(), ids.end());
  return ids;
}

LandmarkId Map::Resolve(LandmarkId id) const {
  // A chain of merges is no longer than the history, and it cannot hold a circle: an id leaves the
  // history when it comes back to life.
  for (size_t step = 0; step <= merged_into_.size(); ++step) {
    if (landmarks_.Contains(id.value)) return id;
    const auto it = merged_into_.find(id);
    if (it == merged_into_.end()) return {};
    id = it->second;
  }
  return {};
}

std::optional<KeyframeRemoval> Map::FindRemoval(KeyframeId id) const {
  const auto it = removals_.find(id);
  if (it == removals_.end()) return std::nullopt;
  return it->second;
}

int Map::SharedLandmarks(KeyframeId a, KeyframeId b) const {
  const MapKeyframe* keyframe = FindKeyframe(a);
  if (keyframe == nullptr) return 0;
  const auto it = std::lower_bound(keyframe->covisible.begin(), keyframe->covisible.end(), b, ById);
  return it != keyframe->covisible.end() && it->first == b ? it->second : 0;
}

std::vector<std::pair<KeyframeId, int32_t>> Map::Neighbours(KeyframeId id, int min_shared) const {
  std::vector<std::pair<KeyframeId, int32_t>> out;
  const MapKeyframe* keyframe = FindKeyframe(id);
  if (keyframe == nullptr) return out;
  for (const auto& entry : keyframe->covisible) {
    if (entry.second >= min_shared) out.push_back(entry);
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first > b.first;
  });
  return out;
}

std::map<KeyframeId, KeyframeId> Map::FirstOfPieces() const {
  std::map<KeyframeId, KeyframeId> first;
  for (const auto& [id, keyframe] : keyframes_) first.try_emplace(keyframe.frame.piece, id);
  return first;
}

bool Map::IsInPieces() const {
  return std::any_of(keyframes_.begin(), keyframes_.end(), [this](const auto& entry) {
    return entry.second.frame.piece != keyframes_.begin()->second.frame.piece;
  });
}

void Map::Share(const Landmark& landmark, KeyframeId keyframe, int32_t delta) {
  auto& covisible = keyframes_.at(keyframe).covisible;
  for (const Observation& other : landmark.observations) {
    if (other.keyframe == keyframe) continue;
    Adjust(covisible, other.keyframe, delta);
    Adjust(keyframes_.at(other.keyframe).covisible, keyframe, delta);
  }
}

bool Map::Link(Landmark& landmark, const Observation& observation) {
  MapKeyframe* keyframe = MutableKeyframe(observation.keyframe);
  if (keyframe == nullptr || observation.feature_index < 0) return false;
  auto& slots = keyframe->frame.landmarks;
  const size_t index = static_cast<size_t>(observation.feature_index);
  if (index >= slots.size() || slots[index].valid()) return false;
  auto& list = landmark.observations;
  const auto at = std::lower_bound(list.begin(), list.end(), observation.keyframe, Before);
  if (at != list.end() && at->keyframe == observation.keyframe) return false;
  list.insert(at, observation);
  slots[index] = landmark.id;
  keyframe->seen.insert(PlaceIn(keyframe->seen, landmark.id),
                        {landmark.id, observation.feature_index});
  ++keyframe->num_observations;
  return true;
}

void Map::Unlink(Landmark& landmark, size_t which) {
  const Observation gone = landmark.observations[which];
  MapKeyframe& keyframe = keyframes_.at(gone.keyframe);
  Share(landmark, gone.keyframe, -1);
  landmark.observations.erase(landmark.observations.begin() + static_cast<std::ptrdiff_t>(which));
  keyframe.frame.landmarks[static_cast<size_t>(gone.feature_index)] = {};
  keyframe.seen.erase(PlaceIn(keyframe.seen, landmark.id));
  --keyframe.num_observations;
}

bool Map::AddKeyframe(const Keyframe& keyframe) {
  if (keyframe.id <= newest_keyframe_ || CheckKeyframe(keyframe) != KeyframeFault::kNone) {
    return false;
  }
  MapKeyframe* previous = MutableKeyframe(keyframe.previous);
  if (previous != nullptr && keyframe.utime <= previous->frame.utime) return false;
  if (previous != nullptr && keyframe.withdraws) Withdraw(keyframe.previous, keyframe.id);
  if (keyframe.length_factor != length_factor_) SetLengthFactor(keyframe.length_factor);
  MapKeyframe& added = keyframes_[keyframe.id];
  added.frame = keyframe;
  added.frame.withdraws = false;  // done, and not to be done again when the map is read
  added.frame.landmarks.assign(keyframe.features.size(), {});
  added.grid = FeatureGrid(keyframe.features);
  if (keyframe.dr && !backend::IsUsable(*keyframe.dr, keyframe.utime)) added.frame.dr.reset();
  if (keyframe.height && !backend::IsUsable(*keyframe.height)) added.frame.height.reset();
  if (previous != nullptr && !previous->next.valid()) {
    previous->next = keyframe.id;
    added.frame.piece = previous->frame.piece;
  } else {
    added.frame.previous = {};
    added.frame.dr.reset();
  }
  newest_keyframe_ = keyframe.id;
  newest_utime_ = keyframe.utime;
  changes_.keyframes.insert(keyframe.id);
  return true;
}

void Map::Withdraw(KeyframeId sound, KeyframeId until) {
  std::set<KeyframeId> withdrawn;
  std::set<LandmarkId> seen;
  for (auto it = keyframes_.upper_bound(sound); it != keyframes_.end() && it->first < until; ++it) {
    if (it->second.frame.piece != PieceOf(sound)) continue;
    withdrawn.insert(it->first);
    for (const auto& [landmark, feature] : it->second.seen) seen.insert(landmark);
  }
  for (const KeyframeId id : withdrawn) RemoveKeyframe(id, sound);
  for (const LandmarkId id : seen) {
    if (withdrawn.contains(id.creator()) || FindLandmark(id)->observations.empty()) {
      RemoveLandmark(id);
    }
  }
}

void Map::SetPose(KeyframeId id, const SE3& T_WC) {
  MapKeyframe* keyframe = MutableKeyframe(id);
  GW_CHECK(keyframe != nullptr);
  keyframe->frame.T_WC = T_WC;
  changes_.keyframes.insert(id);
}

void Map::JoinPiece(KeyframeId from, KeyframeId into, const SE3& T_IntoFrom) {
  GW_CHECK(from.valid() && from != into);
  std::set<LandmarkId> landmarks;
  for (auto& [id, keyframe] : keyframes_) {
    if (keyframe.frame.piece != from) continue;
    keyframe.frame.piece = into;
    SetPose(id, T_IntoFrom * keyframe.frame.T_WC);
    for (const auto& [landmark, feature] : keyframe.seen) landmarks.insert(landmark);
  }
  for (const LandmarkId id : landmarks) {
    Landmark& landmark = MutableLandmark(id);
    landmark.p_W = T_IntoFrom * landmark.p_W;
    landmark.normal_W = T_IntoFrom.rotation() * landmark.normal_W;
  }
}

void Map::SetLengthFactor(double factor) {
  GW_CHECK(factor > 0);
  const double by = factor / std::exchange(length_factor_, factor);
  std::map<KeyframeId, Eigen::Vector3d> centers;
  for (const auto& [piece, first] : FirstOfPieces()) {
    centers[piece] = keyframes_.at(first).frame.T_WC.translation();
  }
  const auto scaled = [&](KeyframeId piece, const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return ScaleAround(centers.at(piece), by, p);
  };
  for (auto& [id, keyframe] : keyframes_) {
    const SE3& T_WC = keyframe.frame.T_WC;
    SetPose(id, SE3(T_WC.rotation(), scaled(keyframe.frame.piece, T_WC.translation())));
    ScaleLengths(by, &keyframe.frame.features);
    keyframe.frame.length_factor = factor;
  }
  for (const LandmarkId id : SortedLandmarkIds()) {
    Landmark& landmark = MutableLandmark(id);
    landmark.min_distance *= static_cast<float>(by);
    landmark.max_distance *= static_cast<float>(by);
    if (landmark.observations.empty()) continue;
    landmark.p_W = scaled(PieceOf(landmark.observations.front().keyframe), landmark.p_W);
  }
  for (auto& [id, removal] : removals_) {
    removal.T_ParentC = ScaleLength(by, removal.T_ParentC);
  }
}

Landmark& Map::AddLandmark(LandmarkId id) {
  const auto [landmark, inserted] = landmarks_.Insert(id.value);
  GW_CHECK(inserted);
  landmark->id = id;
  merged_into_.erase(id);
  changes_.landmarks.push_back(id);
  return *landmark;
}

Landmark& Map::MutableLandmark(LandmarkId id) {
  Landmark* landmark = landmarks_.Find(id.value);
  GW_CHECK(landmark != nullptr);
  changes_.landmarks.push_back(id);
  return *landmark;
}

bool Map::AddObservation(LandmarkId id, const Observation& observation) {
  Landmark* landmark = landmarks_.Find(id.value);
  GW_CHECK(landmark != nullptr);
  if (!Link(*landmark, observation)) return false;
  Share(*landmark, observation.keyframe, 1);
  changes_.landmarks.push_back(id);
  return true;
}

void Map::RemoveObservation(LandmarkId id, KeyframeId keyframe) {
  Landmark& landmark = MutableLandmark(id);
  const auto& list = landmark.observations;
  const auto it = std::lower_bound(list.begin(), list.end(), keyframe, Before);
  if (it == list.end() || it->keyframe != keyframe) return;
  Unlink(landmark, static_cast<size_t>(it - list.begin()));
}

void Map::MergeLandmark(LandmarkId from, LandmarkId into) {
  GW_CHECK(from != into);
  const std::vector<Observation> moving = MutableLandmark(from).observations;
  EraseLandmark(from);
  for (const Observation& observation : moving) AddObservation(into, observation);
  RecordMerge(from, into);
  changes_.landmarks.push_back(into);
  changes_.merged.push_back({from, into});
}

void Map::RemoveLandmark(LandmarkId id) {
  EraseLandmark(id);
  changes_.removed.push_back(id);
}

void Map::EraseLandmark(LandmarkId id) {
  Landmark* landmark = landmarks_.Find(id.value);
  if (landmark == nullptr) return;
  while (!landmark->observations.empty()) Unlink(*landmark, landmark->observations.size() - 1);
  landmarks_.Erase(id.value);
}

void Map::RemoveKeyframe(KeyframeId id, KeyframeId parent) {
  const MapKeyframe* keyframe = FindKeyframe(id);
  const MapKeyframe* stays = FindKeyframe(parent);
  GW_CHECK(keyframe != nullptr && stays != nullptr && id != parent);
  const std::vector<LandmarkId> observed = keyframe->frame.landmarks;
  for (const LandmarkId landmark : observed) {
    if (landmark.valid()) RemoveObservation(landmark, id);
  }
  const KeyframeRemoval removal{id, parent, stays->frame.T_WC.inverse() * keyframe->frame.T_WC};
  RecordRemoval(removal);
  // The bridge's weight may come from changes that the receiver has not seen: say it.
  if (FindKeyframe(keyframe->next) != nullptr) changes_.dr_edges.insert(keyframe->next);
  EraseKeyframe(id);
  changes_.keyframes.erase(id);
  changes_.dr_edges.erase(id);
  changes_.removed_keyframes.push_back(removal);
}

// The chain stays connected: the keyframe after gets the composed motion from the one before. The
// stronger of the two DR weights is kept, because the bridge is as weak in vision as its weaker
// part.
void Map::EraseKeyframe(KeyframeId id) {
  const MapKeyframe& gone = keyframes_.at(id);
  MapKeyframe* previous = MutableKeyframe(gone.frame.previous);
  MapKeyframe* next = MutableKeyframe(gone.next);
  if (next != nullptr) {
    const bool bridged = previous != nullptr && gone.frame.dr && next->frame.dr;
    if (bridged) {
      next->frame.dr = Compose(*gone.frame.dr, *next->frame.dr);
    } else {
      next->frame.dr.reset();
    }
    next->frame.previous = previous != nullptr ? gone.frame.previous : KeyframeId{};
    next->dr_alpha = bridged ? std::max(next->dr_alpha, gone.dr_alpha) : 0;
  }
  if (previous != nullptr) previous->next = gone.next;
  keyframes_.erase(id);
}

void Map::RecordMerge(LandmarkId from, LandmarkId into) {
  merged_into_[from] = into;
  while (merged_into_.size() > kMaxMerges) merged_into_.erase(merged_into_.begin());
}

void Map::RecordRemoval(const KeyframeRemoval& removal) {
  // Those that lived on relative to the one that goes now hang on its parent.
  for (auto& [id, entry] : removals_) {
    if (entry.parent != removal.id) continue;
    entry.parent = removal.parent;
    entry.T_ParentC = removal.T_ParentC * entry.T_ParentC;
  }
  removals_[removal.id] = removal;
  while (removals_.size() > kMaxRemovals) removals_.erase(removals_.begin());
}

void Map::SetDrAlpha(KeyframeId to, double alpha) {
  MapKeyframe* keyframe = MutableKeyframe(to);
  GW_CHECK(keyframe != nullptr);
  keyframe->dr_alpha = alpha;
  changes_.dr_edges.insert(to);
}

}  // namespace gw::backend

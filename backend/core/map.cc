#include "backend/core/map.h"

#include <algorithm>
#include <string_view>

#include "backend/core/keyframe_check.h"
#include "common/core/check.h"
#include "common/core/hash.h"

namespace gw::backend {
namespace {

// Histories answer for keyframes that are on their way, so minutes would do; these last for hours.
constexpr size_t kMaxMerges = 1 << 16;
constexpr size_t kMaxRemovals = 1 << 14;

class Hasher {
 public:
  template <typename T>
  void Add(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    hash_ = Fnv1a({reinterpret_cast<const char*>(&value), sizeof(value)}, hash_);
  }
  void Add(const SE3& T) {
    for (int i = 0; i < 4; ++i) Add(T.rotation().coeffs()[i]);
    for (int i = 0; i < 3; ++i) Add(T.translation()[i]);
  }
  void Add(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) Add(v[i]);
  }
  uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = kFnvOffset;
};

bool Lists(const std::vector<Observation>& sorted, const Observation& observation) {
  return std::binary_search(sorted.begin(), sorted.end(), observation);
}

bool ById(const std::pair<KeyframeId, int32_t>& a, KeyframeId b) {
  return a.first < b;
}

std::vector<Observation>::const_iterator FindObservation(const Landmark& landmark,
                                                         KeyframeId keyframe) {
  const auto it =
      std::lower_bound(landmark.observations.begin(), landmark.observations.end(), keyframe,
                       [](const Observation& o, KeyframeId k) { return o.keyframe < k; });
  return it != landmark.observations.end() && it->keyframe == keyframe
             ? it
             : landmark.observations.end();
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
  const auto it = landmarks_.find(id.value);
  return it == landmarks_.end() ? nullptr : &it->second;
}

std::vector<LandmarkId> Map::SortedLandmarkIds() const {
  std::vector<LandmarkId> ids;
  ids.reserve(landmarks_.size());
  for (const auto& [id, landmark] : landmarks_) ids.push_back({id});
  std::sort(ids.begin(), ids.end());
  return ids;
}

LandmarkId Map::Resolve(LandmarkId id) const {
  // A chain of merges is no longer than the history, and it cannot hold a circle: an id leaves the
  // history when it comes back to life.
  for (size_t step = 0; step <= merged_into_.size(); ++step) {
    if (landmarks_.contains(id.value)) return id;
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

void Map::AdjustCovisibility(KeyframeId a, KeyframeId b, int32_t delta) {
  for (int side = 0; side < 2; ++side, std::swap(a, b)) {
    MapKeyframe* keyframe = MutableKeyframe(a);
    if (keyframe == nullptr) continue;
    auto& list = keyframe->covisible;
    const auto it = std::lower_bound(list.begin(), list.end(), b, ById);
    if (it == list.end() || it->first != b) {
      list.insert(it, {b, delta});
    } else if ((it->second += delta) == 0) {
      list.erase(it);
    }
  }
}

void Map::Link(const Landmark& landmark, const Observation& observation) {
  MapKeyframe& keyframe = keyframes_.at(observation.keyframe);
  auto& slots = keyframe.frame.landmarks;
  ++keyframe.num_observations;
  const size_t index = static_cast<size_t>(observation.feature_index);
  if (index < slots.size()) slots[index] = landmark.id;
  for (const Observation& other : landmark.observations) {
    if (other.keyframe != observation.keyframe) {
      AdjustCovisibility(observation.keyframe, other.keyframe, 1);
    }
  }
}

void Map::Unlink(const Landmark& landmark, const Observation& observation) {
  MapKeyframe& keyframe = keyframes_.at(observation.keyframe);
  auto& slots = keyframe.frame.landmarks;
  --keyframe.num_observations;
  const size_t index = static_cast<size_t>(observation.feature_index);
  if (index < slots.size() && slots[index] == landmark.id) slots[index] = {};
  for (const Observation& other : landmark.observations) {
    if (other.keyframe != observation.keyframe) {
      AdjustCovisibility(observation.keyframe, other.keyframe, -1);
    }
  }
}

bool Map::AddKeyframe(const Keyframe& keyframe) {
  if (keyframe.id <= newest_keyframe_ || CheckKeyframe(keyframe) != KeyframeFault::kNone) {
    return false;
  }
  MapKeyframe* previous = MutableKeyframe(keyframe.previous);
  if (previous != nullptr && keyframe.utime <= previous->frame.utime) return false;
  MapKeyframe& added = keyframes_[keyframe.id];
  added.frame = keyframe;
  added.frame.landmarks.assign(keyframe.features.size(), {});
  added.grid = FeatureGrid(keyframe.features);
  if (keyframe.dr && !backend::IsUsable(*keyframe.dr, keyframe.utime)) added.frame.dr.reset();
  if (previous != nullptr && !previous->next.valid()) {
    previous->next = keyframe.id;
  } else {
    added.frame.previous = {};
    added.frame.dr.reset();
  }
  newest_keyframe_ = keyframe.id;
  newest_utime_ = keyframe.utime;
  changes_.keyframes.insert(keyframe.id);
  return true;
}

void Map::SetPose(KeyframeId id, const SE3& T_WC) {
  MapKeyframe* keyframe = MutableKeyframe(id);
  GW_CHECK(keyframe != nullptr);
  keyframe->frame.T_WC = T_WC;
  changes_.keyframes.insert(id);
}

Landmark& Map::AddLandmark(LandmarkId id) {
  const auto [it, inserted] = landmarks_.try_emplace(id.value);
  GW_CHECK(inserted);
  it->second.id = id;
  merged_into_.erase(id);
  changes_.landmarks.push_back(id);
  return it->second;
}

Landmark& Map::MutableLandmark(LandmarkId id) {
  const auto it = landmarks_.find(id.value);
  GW_CHECK(it != landmarks_.end());
  changes_.landmarks.push_back(id);
  return it->second;
}

bool Map::AddObservation(LandmarkId id, const Observation& observation) {
  const auto it = landmarks_.find(id.value);
  GW_CHECK(it != landmarks_.end());
  if (!Observe(it->second, observation)) return false;
  changes_.landmarks.push_back(id);
  return true;
}

bool Map::Observe(Landmark& landmark, const Observation& observation) {
  const MapKeyframe* keyframe = FindKeyframe(observation.keyframe);
  if (keyframe == nullptr || observation.feature_index < 0) return false;
  const size_t index = static_cast<size_t>(observation.feature_index);
  const auto& slots = keyframe->frame.landmarks;
  if (!slots.empty() && (index >= slots.size() || slots[index].valid())) return false;
  if (FindObservation(landmark, observation.keyframe) != landmark.observations.end()) return false;
  landmark.observations.insert(
      std::lower_bound(landmark.observations.begin(), landmark.observations.end(), observation),
      observation);
  Link(landmark, observation);
  return true;
}

void Map::RemoveObservation(LandmarkId id, KeyframeId keyframe) {
  Landmark& landmark = MutableLandmark(id);
  const auto it = FindObservation(landmark, keyframe);
  if (it == landmark.observations.end()) return;
  Unlink(landmark, *it);
  landmark.observations.erase(it);
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
  const auto it = landmarks_.find(id.value);
  if (it == landmarks_.end()) return;
  Landmark& landmark = it->second;
  while (!landmark.observations.empty()) {
    Unlink(landmark, landmark.observations.back());
    landmark.observations.pop_back();
  }
  landmarks_.erase(it);
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

void Map::StripObservations(KeyframeId keyframe) {
  for (const LandmarkId id : SortedLandmarkIds()) {
    Landmark& landmark = landmarks_.at(id.value);
    const auto it = FindObservation(landmark, keyframe);
    if (it == landmark.observations.end()) continue;
    ++num_ignored_;
    Unlink(landmark, *it);
    landmark.observations.erase(it);
  }
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

MapUpdate Map::Commit() {
  MapUpdate out;
  out.utime = newest_utime_;
  out.base_revision = revision_;
  out.revision = ++revision_;
  out.newest_keyframe = newest_keyframe_;
  for (const KeyframeId id : changes_.keyframes) {
    const MapKeyframe& keyframe = keyframes_.at(id);
    out.keyframes.push_back({id, keyframe.frame.utime, keyframe.frame.T_WC});
  }
  out.removed_keyframes = std::move(changes_.removed_keyframes);
  const auto sort_unique = [](auto& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  sort_unique(changes_.landmarks);
  sort_unique(changes_.removed);
  for (const LandmarkId id : changes_.landmarks) {
    if (const Landmark* landmark = FindLandmark(id)) out.landmarks.push_back(*landmark);
  }
  for (const LandmarkId id : changes_.removed) {
    if (FindLandmark(id) == nullptr) out.removed_landmarks.push_back(id);
  }
  for (const LandmarkMerge& merge : changes_.merged) {
    if (FindLandmark(merge.from) == nullptr) out.merged_landmarks.push_back(merge);
  }
  for (const KeyframeId id : changes_.dr_edges) {
    const MapKeyframe& keyframe = keyframes_.at(id);
    out.dr_edges.push_back({keyframe.frame.previous, id, keyframe.dr_alpha});
  }
  changes_ = {};
  return out;
}

bool Map::IsUsable(const LandmarkUpdate& update) const {
  return update.id.valid() && update.id.creator() <= newest_keyframe_ && IsInReach(update.p_W) &&
         update.normal_W.allFinite();
}

void Map::DropUnlistedObservations(const LandmarkUpdate& update) {
  const auto it = landmarks_.find(update.id.value);
  if (it == landmarks_.end() || !IsUsable(update)) return;
  std::vector<Observation>& present = it->second.observations;
  for (size_t i = present.size(); i-- > 0;) {
    if (Lists(update.observations, present[i])) continue;
    Unlink(it->second, present[i]);
    present.erase(present.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

bool Map::TakeLandmark(const LandmarkUpdate& update) {
  if (!IsUsable(update)) return false;
  merged_into_.erase(update.id);
  Landmark& landmark = landmarks_[update.id.value];
  landmark.id = update.id;
  for (const Observation& observation : update.observations) {
    // Those that stay are not touched: most updates only move the point.
    if (Lists(landmark.observations, observation)) continue;
    if (!Observe(landmark, observation)) ++num_ignored_;
  }
  landmark.p_W = update.p_W;
  landmark.normal_W = update.normal_W;
  landmark.min_distance = update.min_distance;
  landmark.max_distance = update.max_distance;
  landmark.descriptor = update.descriptor;
  return true;
}

// What is left are the keyframes that the snapshot names, and nothing that hangs on them.
void Map::ClearFor(const MapUpdate& snapshot) {
  for (const LandmarkId id : SortedLandmarkIds()) EraseLandmark(id);
  merged_into_.clear();
  removals_.clear();
  std::set<KeyframeId> named;
  for (const KeyframeUpdate& keyframe : snapshot.keyframes) {
    if (keyframe.id <= snapshot.newest_keyframe) named.insert(keyframe.id);
  }
  std::erase_if(keyframes_, [&](const auto& entry) { return !named.contains(entry.first); });
  for (auto& [id, keyframe] : keyframes_) {
    keyframe.dr_alpha = 0;
    if (!keyframes_.contains(keyframe.next)) keyframe.next = {};
    if (!keyframes_.contains(keyframe.frame.previous)) {
      keyframe.frame.previous = {};
      keyframe.frame.dr.reset();
    }
  }
}

bool Map::TakePose(const KeyframeUpdate& update) {
  if (!update.id.valid() || update.id > newest_keyframe_ || !update.T_WC.IsFinite() ||
      !IsInReach(update.T_WC.translation())) {
    return false;
  }
  const auto [it, is_new] = keyframes_.try_emplace(update.id);
  Keyframe& frame = it->second.frame;
  if (is_new) {
    frame.id = update.id;
    frame.utime = update.utime;
  } else if (frame.utime != update.utime) {
    return false;
  }
  frame.T_WC = update.T_WC;
  return true;
}

bool Map::TakeRemoval(const KeyframeRemoval& removal, bool snapshot) {
  if (removal.id == removal.parent || removal.id > newest_keyframe_ ||
      !keyframes_.contains(removal.parent) || !removal.T_ParentC.IsFinite()) {
    return false;
  }
  const MapKeyframe* keyframe = FindKeyframe(removal.id);
  if (snapshot) {
    if (keyframe == nullptr) removals_[removal.id] = removal;
    return keyframe == nullptr;
  }
  if (keyframe != nullptr) {
    if (keyframe->num_observations > 0) StripObservations(removal.id);
    EraseKeyframe(removal.id);
  }
  RecordRemoval(removal);
  return true;
}

bool Map::TakeDrWeight(const DrEdgeWeight& edge) {
  MapKeyframe* keyframe = MutableKeyframe(edge.to);
  if (keyframe == nullptr || !(edge.alpha >= 0)) return false;
  keyframe->dr_alpha = edge.alpha;
  return true;
}

Map::Applied Map::Apply(const MapUpdate& update) {
  if (!update.snapshot && update.base_revision != revision_) return Applied::kGap;
  const auto count = [this](bool taken) { num_ignored_ += taken ? 0 : 1; };
  if (update.snapshot) ClearFor(update);
  if (update.newest_keyframe > newest_keyframe_ || update.snapshot) {
    newest_keyframe_ = update.newest_keyframe;
  }
  for (const KeyframeUpdate& moved : update.keyframes) count(TakePose(moved));
  for (const LandmarkMerge& merge : update.merged_landmarks) {
    EraseLandmark(merge.from);
    RecordMerge(merge.from, merge.into);
  }
  for (const LandmarkId id : update.removed_landmarks) EraseLandmark(id);
  // First what goes, then what comes: a feature may pass from one landmark to another.
  for (const LandmarkUpdate& landmark : update.landmarks) DropUnlistedObservations(landmark);
  for (const LandmarkUpdate& landmark : update.landmarks) count(TakeLandmark(landmark));
  for (const KeyframeRemoval& removal : update.removed_keyframes) {
    count(TakeRemoval(removal, update.snapshot));
  }
  for (const DrEdgeWeight& edge : update.dr_edges) count(TakeDrWeight(edge));
  newest_utime_ = update.utime;
  revision_ = update.revision;
  changes_ = {};
  return Applied::kDone;
}

MapUpdate Map::Snapshot() const {
  MapUpdate out;
  out.utime = newest_utime_;
  out.revision = revision_;
  out.snapshot = true;
  out.newest_keyframe = newest_keyframe_;
  for (const auto& [id, keyframe] : keyframes_) {
    out.keyframes.push_back({id, keyframe.frame.utime, keyframe.frame.T_WC});
    if (keyframe.dr_alpha > 0) {
      out.dr_edges.push_back({keyframe.frame.previous, id, keyframe.dr_alpha});
    }
  }
  for (const auto& [id, removal] : removals_) out.removed_keyframes.push_back(removal);
  for (const LandmarkId id : SortedLandmarkIds()) {
    out.landmarks.push_back(landmarks_.at(id.value));
  }
  for (const auto& [from, into] : merged_into_) out.merged_landmarks.push_back({from, into});
  return out;
}

uint64_t Map::Hash() const {
  Hasher h;
  h.Add(revision_);
  h.Add(newest_keyframe_.value);
  h.Add(newest_utime_.us);
  for (const auto& [id, keyframe] : keyframes_) {
    const Keyframe& f = keyframe.frame;
    h.Add(id.value);
    h.Add(f.utime.us);
    h.Add(f.T_WC);
    h.Add(f.previous.value);
    h.Add(keyframe.next.value);
    h.Add(keyframe.dr_alpha);
    if (f.dr) {
      h.Add(f.dr->T_BaBb);
      for (int i = 0; i < 36; ++i) h.Add(f.dr->cov.data()[i]);
      h.Add(f.dr->utime_begin.us);
      h.Add(f.dr->utime_end.us);
    }
    h.Add(f.features.size());
    for (const LandmarkId landmark : f.landmarks) h.Add(landmark.value);
    for (const auto& [other, shared] : keyframe.covisible) {
      h.Add(other.value);
      h.Add(shared);
    }
  }
  for (const LandmarkId id : SortedLandmarkIds()) {
    const Landmark& landmark = landmarks_.at(id.value);
    h.Add(id.value);
    h.Add(landmark.p_W);
    h.Add(landmark.normal_W);
    h.Add(landmark.min_distance);
    h.Add(landmark.max_distance);
    for (const uint64_t word : landmark.descriptor) h.Add(word);
    for (const Observation& observation : landmark.observations) {
      h.Add(observation.keyframe.value);
      h.Add(observation.feature_index);
    }
  }
  for (const auto& [id, removal] : removals_) {
    h.Add(id.value);
    h.Add(removal.parent.value);
    h.Add(removal.T_ParentC);
  }
  for (const auto& [from, into] : merged_into_) {
    h.Add(from.value);
    h.Add(into.value);
  }
  return h.value();
}

}  // namespace gw::backend

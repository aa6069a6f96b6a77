// What a map tells and takes as one MapUpdate; its hash.
#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <unordered_map>

#include "backend/core/map/keyframe_check.h"
#include "backend/core/map/map.h"
#include "common/core/hash.h"

namespace gw::backend {
namespace {

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

}  // namespace

MapUpdate Map::Commit() {
  MapUpdate out;
  out.utime = newest_utime_;
  out.base_revision = revision_;
  out.revision = ++revision_;
  out.newest_keyframe = newest_keyframe_;
  out.length_factor = length_factor_;
  for (const KeyframeId id : changes_.keyframes) {
    const MapKeyframe& keyframe = keyframes_.at(id);
    out.keyframes.push_back({id, keyframe.frame.utime, keyframe.frame.T_WC, keyframe.frame.piece});
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
  Landmark* landmark = landmarks_.Find(update.id.value);
  if (landmark == nullptr || !IsUsable(update)) return;
  std::vector<Observation>& present = landmark->observations;
  for (size_t i = present.size(); i-- > 0;) {
    if (Lists(update.observations, present[i])) continue;
    Unlink(*landmark, i);
  }
}

bool Map::TakeLandmark(const LandmarkUpdate& update, bool snapshot) {
  if (!IsUsable(update)) return false;
  merged_into_.erase(update.id);
  Landmark& landmark = *landmarks_.Insert(update.id.value).first;
  landmark.id = update.id;
  for (const Observation& observation : update.observations) {
    // Those that stay are not touched: most updates only move the point.
    if (Lists(landmark.observations, observation)) continue;
    if (!Link(landmark, observation)) {
      ++num_ignored_;
    } else if (!snapshot) {
      Share(landmark, observation.keyframe, 1);
    }
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

// A piece becomes part of another with all its keyframes, or not at all.
bool Map::MovesWholePieces(const MapUpdate& update) const {
  std::map<KeyframeId, KeyframeId> into;
  std::set<KeyframeId> named;
  bool moves = false;
  for (const KeyframeUpdate& keyframe : update.keyframes) {
    const MapKeyframe* known = FindKeyframe(keyframe.id);
    if (known == nullptr) continue;
    named.insert(keyframe.id);
    const KeyframeId piece = known->frame.piece;
    if (into.try_emplace(piece, keyframe.piece).first->second != keyframe.piece) return false;
    moves |= piece != keyframe.piece;
  }
  return !moves || std::all_of(keyframes_.begin(), keyframes_.end(), [&](const auto& entry) {
    const auto piece = into.find(entry.second.frame.piece);
    return piece == into.end() || piece->second == piece->first || named.contains(entry.first);
  });
}

bool Map::TakePose(const KeyframeUpdate& update, bool whole_pieces) {
  MapKeyframe* keyframe = MutableKeyframe(update.id);
  if (keyframe == nullptr || update.piece > update.id || update.utime != keyframe->frame.utime ||
      !update.T_WC.IsFinite() || !IsInReach(update.T_WC.translation())) {
    return false;
  }
  keyframe->frame.T_WC = update.T_WC;
  if (whole_pieces) keyframe->frame.piece = update.piece;
  return whole_pieces || keyframe->frame.piece == update.piece;
}

// What Share() counts landmark by landmark, for all of them at once.
void Map::CountCovisibility() {
  std::vector<std::pair<KeyframeId, MapKeyframe*>> keyframes;  // the place here is the rank
  std::unordered_map<int64_t, size_t> rank;
  for (auto& [id, keyframe] : keyframes_) {
    rank[id.value] = keyframes.size();
    keyframes.push_back({id, &keyframe});
  }
  // Observers of one landmark after the other (in any order: they are only counted), and for each
  // keyframe where those after it stand.
  std::vector<size_t> observers;
  std::vector<std::vector<std::pair<size_t, size_t>>> others(keyframes.size());
  landmarks_.ForEach([&](int64_t, const Landmark& landmark) {
    const size_t end = observers.size() + landmark.observations.size();
    for (const Observation& observation : landmark.observations) {
      const size_t observer = rank.at(observation.keyframe.value);
      observers.push_back(observer);
      others[observer].push_back({observers.size(), end});
    }
  });
  std::vector<int32_t> shared(keyframes.size());
  for (size_t a = 0; a < keyframes.size(); ++a) {
    for (const auto& [begin, end] : others[a]) {
      for (size_t i = begin; i < end; ++i) ++shared[observers[i]];
    }
    for (size_t b = a + 1; b < keyframes.size(); ++b) {
      if (shared[b] == 0) continue;
      keyframes[a].second->covisible.push_back({keyframes[b].first, shared[b]});
      keyframes[b].second->covisible.push_back({keyframes[a].first, shared[b]});
      shared[b] = 0;
    }
  }
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
    for (const LandmarkId landmark : std::vector(keyframe->frame.landmarks)) {
      if (!landmark.valid()) continue;
      RemoveObservation(landmark, removal.id);
      ++num_ignored_;
    }
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
  const bool whole_pieces = MovesWholePieces(update);
  for (const KeyframeUpdate& moved : update.keyframes) count(TakePose(moved, whole_pieces));
  for (const LandmarkMerge& merge : update.merged_landmarks) {
    EraseLandmark(merge.from);
    RecordMerge(merge.from, merge.into);
  }
  for (const LandmarkId id : update.removed_landmarks) EraseLandmark(id);
  // First what goes, then what comes: a feature may pass from one landmark to another.
  for (const LandmarkUpdate& landmark : update.landmarks) DropUnlistedObservations(landmark);
  for (const LandmarkUpdate& landmark : update.landmarks) {
    count(TakeLandmark(landmark, update.snapshot));
  }
  if (update.snapshot) CountCovisibility();
  for (const KeyframeRemoval& removal : update.removed_keyframes) {
    count(TakeRemoval(removal, update.snapshot));
  }
  for (const DrEdgeWeight& edge : update.dr_edges) count(TakeDrWeight(edge));
  newest_utime_ = update.utime;
  length_factor_ = update.length_factor;
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
  out.length_factor = length_factor_;
  for (const auto& [id, keyframe] : keyframes_) {
    out.keyframes.push_back({id, keyframe.frame.utime, keyframe.frame.T_WC, keyframe.frame.piece});
    if (keyframe.dr_alpha > 0) {
      out.dr_edges.push_back({keyframe.frame.previous, id, keyframe.dr_alpha});
    }
  }
  for (const auto& [id, removal] : removals_) out.removed_keyframes.push_back(removal);
  for (const LandmarkId id : SortedLandmarkIds()) {
    out.landmarks.push_back(*FindLandmark(id));
  }
  for (const auto& [from, into] : merged_into_) out.merged_landmarks.push_back({from, into});
  return out;
}

uint64_t Map::Hash() const {
  Hasher h;
  h.Add(revision_);
  h.Add(newest_keyframe_.value);
  h.Add(newest_utime_.us);
  if (length_factor_ != 1) h.Add(length_factor_);  // maps of before it was known keep their hash
  for (const auto& [id, keyframe] : keyframes_) {
    const Keyframe& f = keyframe.frame;
    h.Add(id.value);
    h.Add(f.utime.us);
    h.Add(f.T_WC);
    h.Add(f.previous.value);
    if (f.piece.valid()) h.Add(f.piece.value);  // maps of before there were pieces keep their hash
    h.Add(keyframe.next.value);
    h.Add(keyframe.dr_alpha);
    if (f.dr) {
      h.Add(f.dr->T_BaBb);
      for (int i = 0; i < 36; ++i) h.Add(f.dr->cov.data()[i]);
      h.Add(f.dr->utime_begin.us);
      h.Add(f.dr->utime_end.us);
    }
    if (f.height) {
      h.Add(f.height->z);
      h.Add(f.height->variance);
    }
    h.Add(f.features.size());
    for (const LandmarkId landmark : f.landmarks) h.Add(landmark.value);
    for (const auto& [other, shared] : keyframe.covisible) {
      h.Add(other.value);
      h.Add(shared);
    }
  }
  for (const LandmarkId id : SortedLandmarkIds()) {
    const Landmark& landmark = *FindLandmark(id);
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

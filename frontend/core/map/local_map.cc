#include "frontend/core/map/local_map.h"

#include <algorithm>
#include <cmath>

#include "common/vision/scale_lengths.h"

namespace gw::frontend {

LocalMap::LocalMap(const RectifiedCamera& camera, const Pyramid& pyramid)
    : camera_(camera), pyramid_(pyramid) {}

void LocalMap::AddKeyframe(const Keyframe& keyframe) {
  ReplicaKeyframe& entry = keyframes_[keyframe.id];
  entry.T_WC = keyframe.T_WC;
  entry.utime = keyframe.utime;
  entry.piece = keyframe.piece;
  entry.landmarks.clear();
  for (size_t i = 0; i < keyframe.landmarks.size(); ++i) {
    const LandmarkId id = keyframe.landmarks[i];
    if (!id.valid()) continue;
    if (id.creator() == keyframe.id) {
      const Feature& f = keyframe.features[i];
      const Eigen::Vector3d p_C = camera_.Unproject(f.u, f.v, f.depth);
      MapPoint& point = *points_.Insert(id.value).first;
      entry.landmarks.push_back({id, &point});
      point.id = id;
      point.p_W = keyframe.T_WC * p_C;
      point.normal_W = (point.p_W - keyframe.T_WC.translation()).normalized();
      const double max_distance = pyramid_.MaxDistance(p_C.norm(), f.level);
      point.max_distance = static_cast<float>(max_distance);
      point.min_distance = static_cast<float>(pyramid_.MinDistance(max_distance));
      point.descriptor = keyframe.descriptors[i];
      point.observers = {keyframe.id};
      continue;
    }
    MapPoint* const known = points_.Find(id.value);
    entry.landmarks.push_back({id, known});
    if (known == nullptr) continue;
    std::vector<KeyframeId>& observers = known->observers;
    if (observers.empty() || observers.back() < keyframe.id) observers.push_back(keyframe.id);
  }
}

std::optional<Eigen::Vector3d> LocalMap::ScaleLengths(double by) {
  const auto first = std::find_if(keyframes_.begin(), keyframes_.end(), [this](const auto& entry) {
    return entry.second.piece == piece_;
  });
  if (first == keyframes_.end()) return std::nullopt;
  const Eigen::Vector3d center = first->second.T_WC.translation();
  ++visit_;
  for (auto& [id, keyframe] : keyframes_) {
    if (keyframe.piece != piece_) continue;
    keyframe.T_WC =
        SE3(keyframe.T_WC.rotation(), ScaleAround(center, by, keyframe.T_WC.translation()));
    for (const Seen& seen : keyframe.landmarks) {
      MapPoint* const point = Find(seen);
      if (point == nullptr || point->visit == visit_) continue;
      point->visit = visit_;
      point->p_W = ScaleAround(center, by, point->p_W);
      point->min_distance *= static_cast<float>(by);
      point->max_distance *= static_cast<float>(by);
    }
  }
  length_factor_ *= by;
  return center;
}

void LocalMap::Upsert(const LandmarkUpdate& update) {
  MapPoint& point = *points_.Insert(update.id.value).first;
  point.id = update.id;
  point.p_W = update.p_W;
  point.normal_W = update.normal_W;
  point.min_distance = update.min_distance;
  point.max_distance = update.max_distance;
  point.descriptor = update.descriptor;
  std::vector<KeyframeId> observers;
  observers.reserve(update.observations.size() + 1);
  for (const Observation& o : update.observations) observers.push_back(o.keyframe);
  // Own keyframes that the back-end has not seen yet still observe it.
  for (const KeyframeId id : point.observers) {
    if (observers.empty() || id > observers.back()) observers.push_back(id);
  }
  for (const KeyframeId id : observers) {
    if (std::binary_search(point.observers.begin(), point.observers.end(), id)) continue;
    const auto keyframe = keyframes_.find(id);
    if (keyframe != keyframes_.end()) keyframe->second.landmarks.push_back({update.id, &point});
  }
  point.observers = std::move(observers);
}

// Keyframes that the back-end did not know yet, and their landmarks, move with the newest one it
// knew.
void LocalMap::MovePending(const MapUpdate& update,
                           const std::map<KeyframeId, ReplicaKeyframe>& all_before) {
  const auto anchor = keyframes_.find(update.newest_keyframe);
  const auto before = all_before.find(update.newest_keyframe);
  if (anchor == keyframes_.end() || before == all_before.end()) return;
  const SE3 T_correction = anchor->second.T_WC * before->second.T_WC.inverse();
  for (auto it = std::next(anchor); it != keyframes_.end(); ++it) {
    if (it->second.piece != before->second.piece) continue;
    it->second.piece = anchor->second.piece;
    it->second.T_WC = T_correction * it->second.T_WC;
    for (const Seen& seen : it->second.landmarks) {
      if (seen.id.creator() != it->first) continue;
      MapPoint* point = Find(seen);
      if (point == nullptr) continue;
      point->p_W = T_correction * point->p_W;
      point->normal_W = T_correction.rotation() * point->normal_W;
    }
  }
}

bool LocalMap::Apply(const MapUpdate& update) {
  if (!update.snapshot) {
    if (update.revision <= revision_) return true;
    if (update.base_revision != revision_) return false;
  }
  if (update.snapshot && keyframes_.empty()) length_factor_ = update.length_factor;
  // All that is in other lengths comes again when the back-end knows better.
  if (update.snapshot || update.length_factor == length_factor_) TakePlaces(update);
  for (const LandmarkMerge& m : update.merged_landmarks) points_.Erase(m.from.value);
  for (const LandmarkId id : update.removed_landmarks) points_.Erase(id.value);
  for (const KeyframeRemoval& k : update.removed_keyframes) keyframes_.erase(k.id);
  revision_ = update.revision;
  if (update.snapshot) {
    known_ = true;
    frozen_ = update.frozen;
  }
  return true;
}

void LocalMap::TakePlaces(const MapUpdate& update) {
  std::map<KeyframeId, ReplicaKeyframe> before;  // without what they see
  if (update.snapshot) {
    // Keep own keyframes that the back-end has not seen; everything else comes with the snapshot.
    for (auto it = keyframes_.begin(); it != keyframes_.end();) {
      it = it->first <= update.newest_keyframe ? keyframes_.erase(it) : std::next(it);
    }
    std::vector<int64_t> known;
    points_.ForEach([&](int64_t id, const MapPoint&) {
      if (LandmarkId{id}.creator() <= update.newest_keyframe) known.push_back(id);
    });
    for (const int64_t id : known) points_.Erase(id);
  }
  for (const KeyframeUpdate& k : update.keyframes) {
    ReplicaKeyframe& entry = keyframes_[k.id];
    before[k.id] = {entry.T_WC, entry.utime, entry.piece, {}, 0};
    entry.T_WC = k.T_WC;
    entry.utime = k.utime;
    entry.piece = k.piece;
  }
  if (!update.snapshot) MovePending(update, before);
  for (const LandmarkUpdate& l : update.landmarks) Upsert(l);
}

const MapPoint* LocalMap::Find(LandmarkId id) const {
  return points_.Find(id.value);
}

std::optional<Eigen::Vector2d> LocalMap::PixelOf(LandmarkId id, const SE3& T_CW) const {
  const MapPoint* const point = Find(id);
  if (point == nullptr) return std::nullopt;
  const Eigen::Vector3d p_C = T_CW * point->p_W;
  if (p_C.z() <= 0) return std::nullopt;
  const Eigen::Vector2d uv = camera_.Project(p_C);
  return camera_.InImage(uv) ? std::optional(uv) : std::nullopt;
}

int LocalMap::NumLandmarks(KeyframeId id) const {
  const auto keyframe = keyframes_.find(id);
  if (keyframe == keyframes_.end()) return 0;
  const auto& named = keyframe->second.landmarks;
  return static_cast<int>(std::count_if(
      named.begin(), named.end(), [&](const Seen& seen) { return Find(seen.id) != nullptr; }));
}

std::optional<SE3> LocalMap::KeyframePose(KeyframeId id) const {
  const auto it = keyframes_.find(id);
  if (it == keyframes_.end()) return std::nullopt;
  return it->second.T_WC;
}

std::optional<KeyframeId> LocalMap::PieceOf(KeyframeId id) const {
  const auto it = keyframes_.find(id);
  if (it == keyframes_.end()) return std::nullopt;
  return it->second.piece;
}

void LocalMap::CollectAround(const std::vector<LandmarkId>& tracked, KeyframeId reference,
                             int max_keyframes, std::vector<const MapPoint*>* points,
                             KeyframeId* best) {
  points->clear();
  *best = reference;
  for (auto& [id, keyframe] : keyframes_) keyframe.votes = 0;
  for (const LandmarkId id : tracked) {
    const MapPoint* point = Find(id);
    if (point == nullptr) continue;
    for (const KeyframeId observer : point->observers) {
      const auto it = keyframes_.find(observer);
      if (it != keyframes_.end()) ++it->second.votes;
    }
  }
  std::vector<std::pair<int, KeyframeId>> ranked;  // most votes first, then newest
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.votes > 0 || id == reference) ranked.emplace_back(keyframe.votes, id);
  }
  std::sort(ranked.begin(), ranked.end(), std::greater<>());
  if (!ranked.empty() && ranked.front().first > 0) *best = ranked.front().second;
  if (static_cast<int>(ranked.size()) > max_keyframes) ranked.resize(max_keyframes);
  if (std::none_of(ranked.begin(), ranked.end(),
                   [&](const auto& r) { return r.second == reference; }) &&
      keyframes_.count(reference) != 0) {
    ranked.emplace_back(0, reference);
  }

  ++visit_;
  for (const auto& [votes, id] : ranked) AppendLandmarksOf(id, points);
}

void LocalMap::AppendLandmarksOf(KeyframeId id, std::vector<const MapPoint*>* points) {
  // Forget landmarks that are gone while we walk over them.
  std::vector<Seen>& landmarks = keyframes_[id].landmarks;
  constexpr size_t kAhead = 8;  // points lie anywhere in memory: ask for them in time
  size_t kept = 0;
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (i + kAhead < landmarks.size()) __builtin_prefetch(landmarks[i + kAhead].point);
    const Seen seen = landmarks[i];
    MapPoint* const point = Find(seen);
    if (point == nullptr) continue;
    landmarks[kept++] = {seen.id, point};
    if (point->visit == visit_) continue;
    point->visit = visit_;
    points->push_back(point);
  }
  landmarks.resize(kept);
}

void LocalMap::CollectNear(const SE3& T_WC, int max_keyframes, std::vector<const MapPoint*>* points,
                           KeyframeId* nearest) {
  points->clear();
  *nearest = {};
  std::vector<std::pair<double, KeyframeId>> ranked;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.landmarks.empty() || keyframe.piece != piece_) continue;
    const SE3 delta = T_WC.inverse() * keyframe.T_WC;
    ranked.emplace_back(delta.translation().norm() + LogSO3(delta.rotation()).norm(), id);
  }
  std::sort(ranked.begin(), ranked.end());
  if (static_cast<int>(ranked.size()) > max_keyframes) ranked.resize(max_keyframes);
  ++visit_;
  for (const auto& [distance, id] : ranked) AppendLandmarksOf(id, points);
  if (!ranked.empty()) *nearest = ranked.front().second;
}

}  // namespace gw::frontend

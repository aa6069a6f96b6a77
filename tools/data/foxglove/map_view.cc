#include "tools/data/foxglove/map_view.h"

#include <set>

namespace gw::foxglove {

void MapView::Take(const gw::Keyframe& keyframe) {
  keyframes_.try_emplace(keyframe.id, Keyframe{keyframe.T_WC, keyframe.piece});
}

void MapView::Take(const MapUpdate& update) {
  if (update.snapshot) {
    keyframes_.clear();
    removed_.clear();
    landmarks_.clear();
    complete_ = true;
  } else if (update.revision <= revision_ && revision_ > 0) {
    return;  // sent again
  } else if (update.base_revision == 0 && revision_ == 0) {
    complete_ = true;  // the map begins with this update
  } else if (update.base_revision != revision_) {
    complete_ = false;
  }
  revision_ = update.revision;
  for (const KeyframeUpdate& k : update.keyframes) keyframes_[k.id] = {k.T_WC, k.piece};
  for (const KeyframeRemoval& r : update.removed_keyframes) {
    keyframes_.erase(r.id);
    removed_[r.id] = {r.parent, r.T_ParentC};
  }
  for (const LandmarkUpdate& l : update.landmarks) {
    landmarks_[l.id.value] = {l.p_W.cast<float>(), static_cast<int>(l.observations.size())};
  }
  for (const LandmarkMerge& m : update.merged_landmarks) landmarks_.erase(m.from.value);
  for (const LandmarkId& id : update.removed_landmarks) landmarks_.erase(id.value);
  for (const LoopEvent& loop : update.loops) {
    if (loop.accepted) loops_.push_back({loop.from, loop.to, loop.T_correction});
  }
}

std::optional<SE3> MapView::KeyframePose(KeyframeId id) const {
  const auto it = keyframes_.find(id);
  return it == keyframes_.end() ? std::nullopt : std::optional(it->second.T_WC);
}

size_t MapView::num_pieces() const {
  std::set<KeyframeId> pieces;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.piece.valid()) pieces.insert(keyframe.piece);
  }
  return pieces.size();
}

bool MapView::InPiece(KeyframeId id) const {
  const auto it = keyframes_.find(id);
  return it != keyframes_.end() && it->second.piece.valid();
}

std::optional<SE3> MapView::PoseNow(KeyframeId id) const {
  SE3 T_KeptC;
  // Parents may leave the map too; the bound guards against a circle in bad data.
  for (size_t i = 0; i <= removed_.size(); ++i) {
    if (const auto T_WK = KeyframePose(id)) return *T_WK * T_KeptC;
    const auto it = removed_.find(id);
    if (it == removed_.end()) return std::nullopt;
    T_KeptC = it->second.T_ParentC * T_KeptC;
    id = it->second.parent;
  }
  return std::nullopt;
}

}  // namespace gw::foxglove

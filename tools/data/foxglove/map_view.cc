#include "tools/data/foxglove/map_view.h"

namespace gw::foxglove {

void MapView::Take(const Keyframe& keyframe) {
  keyframes_.try_emplace(keyframe.id, keyframe.T_WC);
}

void MapView::Take(const MapUpdate& update) {
  if (update.snapshot) {
    keyframes_.clear();
    removed_.clear();
    landmarks_.clear();
    complete_ = true;
  } else if (update.revision <= revision_ && revision_ > 0) {
    return;  // sent again
  } else if (update.base_revision != revision_) {
    complete_ = false;
  }
  revision_ = update.revision;
  for (const KeyframeUpdate& k : update.keyframes) keyframes_[k.id] = k.T_WC;
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
  return it == keyframes_.end() ? std::nullopt : std::optional(it->second);
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

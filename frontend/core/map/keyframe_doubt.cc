#include "frontend/core/map/keyframe_doubt.h"

#include <algorithm>

#include "common/good_weights/camera_motion.h"

namespace gw::frontend {

Matrix6d KeyframeDoubt::At(KeyframeId id, const SE3& T_KC) const {
  const auto found = keyframes_.find(id);
  return found == keyframes_.end() ? Matrix6d::Zero() : InCamera(found->second.cov, T_KC);
}

std::optional<Matrix6d> KeyframeDoubt::Among(const std::vector<LandmarkId>& landmarks,
                                             const LocalMap& map, const SE3& T_WC) const {
  std::map<KeyframeId, int> first_seen;  // landmarks by the keyframe that saw them first
  for (const LandmarkId id : landmarks) {
    const MapPoint* const point = id.valid() ? map.Find(id) : nullptr;
    if (point != nullptr && !point->observers.empty()) ++first_seen[point->observers.front()];
  }
  Matrix6d sum = Matrix6d::Zero();
  int count = 0;
  for (const auto& [keyframe, seen] : first_seen) {
    const auto T_WK = map.KeyframePose(keyframe);
    if (!T_WK) continue;
    sum += seen * At(keyframe, T_WK->inverse() * T_WC);
    count += seen;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

void KeyframeDoubt::Add(KeyframeId id, const Matrix6d& cov_T_WK) {
  double walked = 0;
  if (!keyframes_.empty()) {
    const Entry& before = keyframes_.rbegin()->second;
    walked = before.walked + std::max(0.0, cov_T_WK.trace() - before.cov.trace());
  }
  keyframes_.insert_or_assign(id, Entry{cov_T_WK, walked});
}

// With w the variance walked, of a walk from i that a loop closes at j: a keyframe k between is off
// by what i is and (w_k - w_i)(w_j - w_k) / (w_j - w_i), one after j by what i is and w_k - w_j;
// without the loop by what i is and w_k - w_i.
void KeyframeDoubt::Close(const LoopEvent& loop, const LocalMap& map) {
  const auto [older, newer] = std::minmax(loop.from, loop.to);
  const auto T_WI = map.KeyframePose(older);
  const auto begin = keyframes_.find(older), end = keyframes_.find(newer);
  if (!T_WI || begin == keyframes_.end() || end == keyframes_.end()) return;
  const double w_i = begin->second.walked, w_j = end->second.walked;
  for (auto it = std::next(begin); it != keyframes_.end(); ++it) {
    const auto T_WK = map.KeyframePose(it->first);
    if (!T_WK) continue;
    const double w_k = it->second.walked;
    const double whole = std::max(w_j, w_k) - w_i;
    const double left = whole > 0 ? std::abs(w_j - w_k) / whole : 0;
    const Matrix6d tied = left * it->second.cov + (1 - left) * At(older, T_WI->inverse() * *T_WK);
    if (tied.trace() < it->second.cov.trace()) it->second.cov = tied;
  }
}

}  // namespace gw::frontend

#include "frontend/core/tracking/keyframe_chain.h"

#include <algorithm>
#include <vector>

#include "common/core/median.h"
#include "common/vision/scale_lengths.h"
#include "frontend/core/tracking/keyframe_policy.h"

namespace gw::frontend {

void KeyframeChain::Observe(const SE3& T_ab, bool unmatched) {
  T_CkeyC_ = T_CkeyC_ * T_ab;
  ++images_since_;
  unmatched_images_ = unmatched ? unmatched_images_ + 1 : 0;
}

bool KeyframeChain::WantsNext(Utime utime, const FeatureFrame& frame, const FoundPose& found,
                              int num_mapped) const {
  if (void_ || scaled_) return true;
  if (images_since_ < 2) return false;
  KeyframeEvidence e;
  e.since_last = utime - utime_;
  e.vision = found.found;
  e.num_inliers = found.found ? found.num_matchable : 0;
  e.num_mapped = num_mapped;
  std::vector<float> depths;
  for (size_t i = 0; i < frame.features.size(); ++i) {
    if (!frame.features[i].has_depth()) continue;
    depths.push_back(frame.features[i].depth);
    const bool tracked = found.found && found.landmarks[i].valid();
    ++(tracked ? e.num_close_tracked : e.num_close_untracked);
  }
  if (e.num_inliers > 0) {
    // With a budget of matches: as many again as were left out.
    const int close = e.num_close_tracked + e.num_close_untracked;
    const int matchable = e.num_close_tracked * e.num_inliers / found.estimate.num_inliers;
    e.num_close_tracked = std::min(close, matchable);
    e.num_close_untracked = close - e.num_close_tracked;
  }
  if (!depths.empty()) e.median_depth_m = MedianOf(&depths);
  e.unmatched_images = unmatched_images_;
  e.translation_m = T_CkeyC_.translation().norm();
  e.rotation_rad = LogSO3(T_CkeyC_.rotation()).norm();
  return NeedsKeyframe(e, config_);
}

Keyframe KeyframeChain::Make(const Source& source, const MotionModel& motion) {
  const FeatureFrame& frame = source.frame;
  const std::vector<LandmarkId>& shown = source.found.landmarks;
  Keyframe k;
  k.id = next_;
  k.utime = source.report.utime;
  k.T_WC = source.T_WC;
  k.cov_T_WC = source.cov_T_WC;
  k.map_revision = source.map_revision;
  if (!own_.empty()) {
    k.previous = own_.back().id;
    k.dr = motion.Increment(own_.back().utime, k.utime);
    k.withdraws = void_;
  }
  k.height = motion.Height(k.utime);
  void_ = scaled_ = false;
  k.length_factor = source.length_factor;
  k.piece = source.piece;
  k.q = source.report.q;
  k.num_tracked = source.report.num_tracked;
  k.features = frame.features;
  k.descriptors = frame.descriptors;
  k.landmarks.resize(frame.features.size());
  for (size_t i = 0; i < frame.features.size(); ++i) {
    if (i < shown.size() && shown[i].valid()) {
      k.landmarks[i] = shown[i];
    } else if (frame.features[i].has_depth()) {
      k.landmarks[i] = LandmarkId::From(k.id, static_cast<int>(i));
    }
  }
  own_.push_back({k.id, k.utime});
  while (own_.size() > 1 && k.utime - own_[1].utime > AnchorHistory::kSpan) own_.pop_front();
  next_.value = k.id.value + 1;
  utime_ = k.utime;
  T_CkeyC_ = SE3();
  images_since_ = 0;
  unmatched_images_ = 0;
  return k;
}

KeyframeId KeyframeChain::Void(Utime since) {
  while (own_.size() > 1 && own_.back().utime >= since) {
    own_.pop_back();
    void_ = true;
  }
  return own_.empty() ? KeyframeId{} : own_.back().id;
}

void KeyframeChain::ScaleLengths(double by) {
  scaled_ = true;
  T_CkeyC_ = ScaleLength(by, T_CkeyC_);
}

void KeyframeChain::Skip(KeyframeId newest) {
  next_.value = std::max(next_.value, newest.value + 1);
}

}  // namespace gw::frontend

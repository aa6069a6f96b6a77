#include "frontend/core/tracking/keyframe_policy.h"

#include <algorithm>

namespace gw::frontend {
namespace {

// Below these the view is the same and a keyframe would add nothing (fraction of the scene's depth,
// rad).
constexpr double kStillParallax = 0.015;
constexpr double kStillRotation = 0.02;
// Blind chain (docs/method.md, section 5.8): so often that the DR edges stay short against their
// own noise.
constexpr double kBlindTranslation = 0.4;  // m
constexpr double kBlindRotation = 0.35;    // rad
// Light is back, but the old map is not found: in so many images it is looked for before the map
// goes on with what is seen now. The DR chain joins the two.
constexpr int kLookForOldMap = 10;

}  // namespace

bool NeedsKeyframe(const KeyframeEvidence& e, const FrontendConfig& config) {
  if (!e.vision) {
    const bool moved = e.translation_m > kBlindTranslation || e.rotation_rad > kBlindRotation;
    return moved || (e.num_close_untracked >= config.keyframe_min_close &&
                     e.unmatched_images >= kLookForOldMap);
  }
  const double depth = e.median_depth_m > 0 ? e.median_depth_m : 2.0;
  const bool still = e.translation_m < kStillParallax * depth && e.rotation_rad < kStillRotation;
  const double overlap = e.num_mapped > 0 ? static_cast<double>(e.num_inliers) / e.num_mapped : 0.0;
  if (still) return overlap < 0.4;  // the scene itself changed

  const bool lost_overlap = overlap < config.keyframe_overlap;
  const bool few_close = e.num_close_tracked < config.keyframe_min_close &&
                         e.num_close_untracked > std::max(70, e.num_close_tracked / 2);
  const bool overdue = e.since_last >= Milliseconds(config.keyframe_max_interval_ms);
  return lost_overlap || few_close || overdue;
}

}  // namespace gw::frontend

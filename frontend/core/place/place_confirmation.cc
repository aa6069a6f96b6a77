#include "frontend/core/place/place_confirmation.h"

#include <algorithm>

#include "common/vision/same_place.h"
#include "frontend/core/place/rich_image.h"

namespace gw::frontend {
namespace {

// Largest motion between two images in a row that cannot explain that nothing is recognised.
constexpr double kSmallTranslation = 0.2;  // m
constexpr double kSmallRotation = 0.2;     // rad
constexpr DurationUs kInARow = Milliseconds(300);
// A fall of the inliers to less than this share, and to no more than chance gives, is a break.
constexpr double kCollapse = 0.25;

// True when so little time and motion lie between two images that they must show the same scene.
bool InARow(DurationUs time, const SE3& motion) {
  return time <= kInARow && motion.translation().norm() < kSmallTranslation &&
         LogSO3(motion.rotation()).norm() < kSmallRotation;
}

}  // namespace

bool PlaceConfirmation::Contradicts(const PlaceEvidence& now) const {
  if (!doubts_ || !now.placed || now.relocalised || now.num_detected < kRichImage || !now.T_OC)
    return false;
  if (now.num_inliers >= kByChance) return false;
  if (now.view == ViewVerdict::kOther) return true;
  return good_ && now.num_inliers < kCollapse * good_->num_inliers &&
         InARow(now.utime - good_->utime, good_->T_OC->inverse() * *now.T_OC);
}

bool PlaceConfirmation::Observe(const PlaceEvidence& now) {
  const bool vision = now.num_inliers > 0;
  if (Contradicts(now)) {
    in_doubt_ = true;
  } else if (vision) {
    in_doubt_ = false;
  }
  if (vision) last_vision_ = now.utime;
  const bool well_tracked = now.num_inliers >= kWellTracked;
  on_probation_ = (on_probation_ || now.relocalised) && !well_tracked;
  if ((well_tracked || (vision && on_probation_)) && now.num_detected >= kRichImage && now.T_OC) {
    good_ = now;
    followed_ = !on_probation_;
  } else if (!well_tracked) {
    followed_ = followed_ && now.view == ViewVerdict::kSame && now.dr_trusted;
  }
  const bool patient = !doubts_ || (last_vision_ && now.utime - *last_vision_ < kPatience);
  unsure_ = now.map_there && !vision && (!now.placed || in_doubt() || !patient);
  if (!unsure_) hints_.clear();
  if (!unsure_ || now.num_detected < kRichImage || !now.T_OC) return false;
  if (last_asked_ && now.utime - *last_asked_ < kAskEvery) return false;
  last_asked_ = now.utime;
  return true;
}

bool PlaceConfirmation::Agree(const Hint& a, const Hint& b) {
  const SE3 by_odometry = a.T_OC.inverse() * b.T_OC;
  return SamePlace(by_odometry.inverse() * (a.T_WC.inverse() * b.T_WC),
                   by_odometry.translation().norm());
}

std::optional<PlaceConfirmation::Confirmed> PlaceConfirmation::Take(const PlaceMatch& match,
                                                                    const SE3& T_OC) {
  if (!unsure_ || !match.found) return std::nullopt;
  if (!hints_.empty() && match.utime <= hints_.back().utime) return std::nullopt;
  hints_.push_back({match.utime, match.T_WC, T_OC, match.cov_T_WC});
  while (match.utime - hints_.front().utime > kMemory) hints_.pop_front();
  const auto agreeing = static_cast<size_t>(std::count_if(
      hints_.begin(), hints_.end(), [&](const Hint& hint) { return Agree(hint, hints_.back()); }));
  // One answer that says otherwise asks for one more that agrees.
  if (agreeing < kAgreeing + (hints_.size() - agreeing)) return std::nullopt;
  hints_.clear();
  return Confirmed{match.T_WC * T_OC.inverse(), match.cov_T_WC};
}

}  // namespace gw::frontend

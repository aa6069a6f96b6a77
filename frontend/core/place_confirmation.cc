#include "frontend/core/place_confirmation.h"

#include <algorithm>

namespace gw::frontend {
namespace {

// Largest motion between two images in a row that cannot explain that nothing is recognised.
constexpr double kSmallTranslation = 0.2;  // m
constexpr double kSmallRotation = 0.2;     // rad
constexpr DurationUs kInARow = Milliseconds(300);
// Two answers agree when dead reckoning leads from one to the other this well: a fixed part for
// the answers, and one that grows with the way between them.
constexpr double kAgreeTranslation = 0.15;  // m
constexpr double kAgreeRotation = 0.06;     // rad
constexpr double kAgreePerMetre = 0.05;

// Vision broke between two rich images with hardly any motion.
bool Contradicts(const PlaceEvidence& before, const PlaceEvidence& now) {
  if (!before.vision || now.vision || !before.placed) return false;
  if (before.num_inliers < PlaceConfirmation::kWellTracked) return false;
  if (before.num_detected < PlaceConfirmation::kRich) return false;
  if (now.num_detected < PlaceConfirmation::kRich) return false;
  if (now.utime - before.utime > kInARow || !before.T_OC || !now.T_OC) return false;
  const SE3 motion = before.T_OC->inverse() * *now.T_OC;
  return motion.translation().norm() < kSmallTranslation &&
         LogSO3(motion.rotation()).norm() < kSmallRotation;
}

}  // namespace

bool PlaceConfirmation::Observe(const PlaceEvidence& now) {
  if (before_ && Contradicts(*before_, now)) doubt_since_ = now.utime;
  if (now.vision) last_vision_ = now.utime;
  if (now.vision || (doubt_since_ && now.utime - *doubt_since_ > kDoubtAtMost)) {
    doubt_since_.reset();
  }
  const bool patient = last_vision_ && now.utime - *last_vision_ < kPatience;
  unsure_ = now.map_there && !now.vision && (!now.placed || in_doubt() || !patient);
  if (!unsure_) hints_.clear();
  before_ = now;
  if (!unsure_ || now.num_detected < kRich || !now.T_OC) return false;
  if (last_asked_ && now.utime - *last_asked_ < kAskEvery) return false;
  last_asked_ = now.utime;
  return true;
}

bool PlaceConfirmation::Agree(const Hint& a, const Hint& b) {
  const SE3 by_odometry = a.T_OC.inverse() * b.T_OC;
  const SE3 error = by_odometry.inverse() * (a.T_WC.inverse() * b.T_WC);
  const double way = by_odometry.translation().norm();
  return error.translation().norm() < kAgreeTranslation + kAgreePerMetre * way &&
         LogSO3(error.rotation()).norm() < kAgreeRotation + kAgreePerMetre * way;
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

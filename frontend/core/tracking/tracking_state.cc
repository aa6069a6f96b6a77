#include "frontend/core/tracking/tracking_state.h"

#include "common/good_weights/quality.h"

namespace gw::frontend {
namespace {

// DR counts noticeably from this share of the pose's information: then a fifth of the pose is its.
constexpr double kNoticeableShare = 0.2;

}  // namespace

TrackingState NextState(TrackingState before, const ImageOutcome& outcome) {
  if (outcome.vision || outcome.begins_map || outcome.begins_piece) return TrackingState::kTracking;
  return IsPlaced(before) ? TrackingState::kBlind : TrackingState::kUnplaced;
}

TrackingStatus StatusOf(TrackingState before, const ImageOutcome& outcome) {
  if (outcome.time_reversed) {
    return IsPlaced(before) ? TrackingStatus::kDegraded : TrackingStatus::kLost;
  }
  if (outcome.begins_map) return TrackingStatus::kTracking;
  if (!outcome.map_there) return TrackingStatus::kInitializing;
  if (!outcome.place_known || outcome.unconfirmed || outcome.corrected) {
    return TrackingStatus::kRecovering;
  }
  if (outcome.vision) {
    const bool weak = outcome.q < kHealthyQuality && outcome.dr_share > kNoticeableShare;
    return weak || outcome.contradicted ? TrackingStatus::kDegraded : TrackingStatus::kTracking;
  }
  return outcome.from_dr ? TrackingStatus::kDrOnly : TrackingStatus::kLost;
}

}  // namespace gw::frontend

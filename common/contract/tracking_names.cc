#include "common/contract/tracking_names.h"

namespace gw {

const char* StatusName(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kInitializing:
      return "initializing";
    case TrackingStatus::kTracking:
      return "tracking";
    case TrackingStatus::kDegraded:
      return "degraded";
    case TrackingStatus::kDrOnly:
      return "dr_only";
    case TrackingStatus::kRecovering:
      return "recovering";
    case TrackingStatus::kLost:
      return "lost";
    case TrackingStatus::kInvalid:
      break;
  }
  return "invalid";
}

const char* ReasonName(TrackingReason reason) {
  switch (reason) {
    case TrackingReason::kNone:
      return "none";
    case TrackingReason::kTooFewFeatures:
      return "too_few_features";
    case TrackingReason::kTooFewMatches:
      return "too_few_matches";
    case TrackingReason::kTooFewInliers:
      return "too_few_inliers";
    case TrackingReason::kPoseJump:
      return "pose_jump";
    case TrackingReason::kBadImage:
      return "bad_image";
    case TrackingReason::kNoMap:
      return "no_map";
    case TrackingReason::kTimeReversed:
      return "time_reversed";
    case TrackingReason::kPlaceUnknown:
      return "place_unknown";
    case TrackingReason::kDrContradictsVision:
      return "dr_contradicts_vision";
    case TrackingReason::kFixedInImage:
      return "fixed_in_image";
    case TrackingReason::kEyesApart:
      return "eyes_apart";
    case TrackingReason::kOneEyeTwice:
      return "one_eye_twice";
    case TrackingReason::kEyesExchanged:
      return "eyes_exchanged";
  }
  return "invalid";
}

}  // namespace gw

// What the front-end says of every image.
#pragma once

#include <cstdint>

#include "common/core/ids.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw {

enum class TrackingStatus : int32_t {
  kInvalid = 0,
  kInitializing = 1,  // no map yet: waiting for an image with enough depth
  kTracking = 2,      // vision carries the pose
  kDegraded = 3,      // vision is weak and DR carries noticeable weight, or the two contradict
  kDrOnly = 4,        // no usable vision; the pose is the DR prediction
  kRecovering = 5,    // where in the map is not known, in doubt, not yet confirmed, or only now
  kLost = 6,          // neither vision nor DR; the pose is extrapolated and its covariance says so
};

// Why the status is what it is; one code, the first that applies.
enum class TrackingReason : int32_t {
  kNone = 0,
  kTooFewFeatures = 1,       // the image shows too little (dark, blank, covered)
  kTooFewMatches = 2,        // features, but not those of the local map
  kTooFewInliers = 3,        // matches, but no pose explains them
  kPoseJump = 4,             // vision contradicted DR and the map; refused
  kBadImage = 5,             // wrong size or format, or empty; not used
  kNoMap = 6,                // no landmarks yet
  kTimeReversed = 7,         // the image is not newer than the one before; not used
  kPlaceUnknown = 8,         // not found yet in the map that is there
  kDrContradictsVision = 9,  // healthy vision goes on without dead reckoning, which is wrong
  kFixedInImage = 10,        // most of what is seen is fixed to the camera, and left out
  kEyesApart = 11,           // the two images of a pair are not of one instant: no depth
  kOneEyeTwice = 12,         // they are the same image; not used
  kEyesExchanged = 13,       // left is right; not used
};

struct FramePose {
  static constexpr DurationUs kMotionSpan = Milliseconds(1000);

  Utime utime;      // of the image, mid-exposure
  int64_t seq = 0;  // of the camera message
  SE3 T_WB;
  Matrix6d cov_T_WB = Matrix6d::Zero();  // right perturbation; marginal, in the map of map_revision
  // Covariance of the motion of the body since an earlier image, about kMotionSpan before (right
  // perturbation). Two marginal covariances do not tell it: their errors have much in common.
  int64_t motion_us = 0;  // since that image; 0: there is none
  Matrix6d cov_motion = Matrix6d::Zero();
  TrackingStatus status = TrackingStatus::kInvalid;
  TrackingReason reason = TrackingReason::kNone;
  int32_t num_detected = 0;  // N_det
  int32_t num_tracked = 0;   // N_trk: matched to the local map in the first stage
  int32_t num_inliers = 0;   // of the final pose
  double q = 0;              // tracking quality, [0, 1]
  double alpha = 0;          // FrameDetail::alpha_rotation; 0 = no DR prior used
  double dr_share = 0;  // [0, 1]: share of the DR prior in the trace-normalised pose information
  int64_t map_revision = 0;  // of the map the pose refers to
  KeyframeId reference_keyframe;
  SE3 T_KC;            // this camera in its reference keyframe's camera, for re-expressing later
  int64_t dr_seq = 0;  // newest DR state used; 0 = none
  uint32_t dr_reset_counter = 0;
  int64_t latency_us = 0;  // image arrival to pose; 0 in offline runs
};

}  // namespace gw

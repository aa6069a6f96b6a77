// One image on its way to a pose: what is known of it before, and what was found.
#pragma once

#include "frontend/core/features/feature_frame.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/tracking/pose_finder.h"
#include "frontend/core/tracking/witnesses.h"

namespace gw::frontend {

struct TrackedImage {
  Utime utime;
  const FeatureFrame* of_world = nullptr;  // without what is fixed to the camera
  const FeatureFrame* frame = nullptr;     // ... corrected for the motion
  Motion motion;                           // since the image before; where hinted, from the hint
  SE3 T_ab;                                // since the image before, in any case
  SE3 T_WC_before;                         // where the motion begins
  SE3 T_WC_predicted;                      // and ends
  bool hinted = false;                     // a pose of the DR process is the prediction
  FoundPose found;
  bool agreed = false;   // with DR, around whose prediction the pose was found
  bool snapped = false;  // found from a confirmed place, and believed

  Witnesses::OfDr of_dr() const { return {utime, T_WC_predicted, motion.weight_cov}; }
};

}  // namespace gw::frontend

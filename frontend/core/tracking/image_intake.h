// What an image is worth before its pose is sought: lengths that have proven to be wrong are set
// right, and what is fixed to the camera is left out. When its pose is known, it tells whether
// depth is of the same instant.
#pragma once

#include "common/config/frontend_config.h"
#include "common/core/time.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/motion/scale_witness.h"
#include "frontend/core/tracking/tracked_image.h"
#include "frontend/core/tracking/tracker_parts.h"

namespace gw::frontend {

class ImageIntake {
 public:
  ImageIntake(const FrontendConfig& config, const TrackerParts& parts);

  // Lengths that have proven to be wrong are right from now on, and with them all that was measured
  // with them before. A map that may not be changed keeps its own. True when they changed.
  bool CorrectLengths();

  // The image in metres: the argument, or a copy that stays valid until the next call.
  const FeatureFrame& InMetres(const FeatureFrame& features);

  // The image without what is fixed to the camera; valid until the next call. Where what is fixed
  // has drawn vision along, the track is set back to where dead reckoning leads.
  const FeatureFrame* LeaveOutFixed(Utime utime, const FeatureFrame& in_metres);

  // A pose was found, and is believed.
  void JudgeDepth(const TrackedImage& image);

  // What is wrong with the camera's lengths, and is set right or still to be.
  LengthFault length_fault() const;

 private:
  bool judges_depth_;
  bool looks_for_fixed_;
  MotionModel* motion_;
  ImageCleaner* cleaner_;
  LocalMap* map_;
  PlaceWatch* place_;
  CameraTrack* track_;
  FeatureFrame frame_in_metres_;
};

}  // namespace gw::frontend

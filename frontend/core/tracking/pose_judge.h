// Is the pose that vision found for an image to be believed?
#pragma once

#include "common/config/frontend_config.h"
#include "frontend/core/place/recovery.h"
#include "frontend/core/tracking/tracked_image.h"
#include "frontend/core/tracking/tracker_parts.h"

namespace gw::frontend {

class PoseJudge {
 public:
  PoseJudge(const FrontendConfig& config, const TrackerParts& parts);

  // True when the pose that vision found is taken over; what it finds after it was broken has to
  // prove itself. Call once for an image that has one, after the uncertainty of the track was
  // predicted. Breaks the chain of keyframes where dead reckoning does not lead here.
  bool Believes(const TrackedImage& image);

  // What was found lately says nothing of what comes: vision carries the pose, or finds none.
  void Forget() { recovery_.Reset(); }

  // What the image tells of the place. placed: its pose refers to the map; num_inliers: of the pose
  // from vision, 0 when it has none.
  PlaceEvidence Evidence(const TrackedImage& image, bool placed, int num_inliers) const;

 private:
  bool BelievesAfterBreak(const TrackedImage& image);

  bool asks_;
  MotionModel* motion_;
  LocalMap* map_;
  Witnesses* witnesses_;
  PlaceWatch* place_;
  CameraTrack* track_;
  Recovery recovery_;
};

}  // namespace gw::frontend

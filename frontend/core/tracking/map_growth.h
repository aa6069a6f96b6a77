// When an image begins a map or a piece of one, or becomes a keyframe, and what is made of it then.
#pragma once

#include "common/config/frontend_config.h"
#include "common/contract/map.h"
#include "common/contract/tracking.h"
#include "frontend/core/tracking/tracked_image.h"
#include "frontend/core/tracking/tracker_parts.h"

namespace gw::frontend {

class MapGrowth {
 public:
  MapGrowth(const FrontendConfig& config, const TrackerParts& parts);

  // There is no map yet, and this image shows enough to begin it.
  bool BeginsMap(const FeatureFrame& frame) const;
  // It shows enough to begin a piece of the map, as it would to begin a map.
  bool CanBeginPiece(const FeatureFrame& frame) const;
  // The image, whose pose is decided, is to become a keyframe. vision: that carries the pose.
  bool IsDue(const TrackedImage& image, bool vision) const;

  // Makes a keyframe of the image where the track is, and adds it to the map and what it begins to
  // what is tracked. report: what is published of the image.
  Keyframe Make(const TrackedImage& image, const FramePose& report);

 private:
  bool maps_by_dr_;  // keyframes hang on dead reckoning, too
  MotionModel* motion_;
  LocalMap* map_;
  PlaceWatch* place_;
  CameraTrack* track_;
};

}  // namespace gw::frontend

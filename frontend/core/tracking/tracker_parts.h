// What the steps of tracking one image work with and change. All of it belongs to the tracker, and
// outlives them.
#pragma once

#include "frontend/core/features/image_cleaner.h"
#include "frontend/core/map/local_map.h"
#include "frontend/core/motion/motion_model.h"
#include "frontend/core/place/place_watch.h"
#include "frontend/core/tracking/camera_track.h"
#include "frontend/core/tracking/witnesses.h"

namespace gw::frontend {

struct TrackerParts {
  MotionModel* motion;
  ImageCleaner* cleaner;
  LocalMap* map;
  Witnesses* witnesses;
  PlaceWatch* place;
  CameraTrack* track;
};

}  // namespace gw::frontend

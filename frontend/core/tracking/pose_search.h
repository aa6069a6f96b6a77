// From the prediction of an image to its pose, where there are several to choose from: around the
// prediction of dead reckoning (DR), by vision alone, by the rest of the image (docs/method.md,
// sections 5.10 and 5.12), at a place that was confirmed, or again near the last pose.
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "frontend/core/tracking/pose_finder.h"
#include "frontend/core/tracking/tracked_image.h"
#include "frontend/core/tracking/tracker_parts.h"

namespace gw::frontend {

class PoseSearch {
 public:
  PoseSearch(const FrontendConfig& config, const RectifiedCamera& camera,
             const TrackerParts& parts);

  // Finds the pose of an image in the map, which is not empty. Call after the uncertainty of the
  // track was predicted. Moves the track to a confirmed place where the image is seen there, and
  // back to DR where vision is refuted.
  void Locate(TrackedImage* image);

  // The image becomes a keyframe: looks for the landmarks that were left out (PoseFinder).
  void Complete(FoundPose* found) const { finder_.Complete(map_, found); }

 private:
  bool Departs(Departure d) const { return config_.dr_weight.Departs(d); }
  void Show(const SE3& T_ab, TrackedImage* image);
  PosePrediction Prediction(const TrackedImage& image) const;
  FoundPose Find(TrackedImage* image);
  std::optional<FoundPose> FindAlone(TrackedImage* image, const FoundPose& other);
  bool IsFounded(const TrackedImage& image, const FoundPose& found) const;
  bool IsSudden(const TrackedImage& image, const FoundPose& found) const;
  FoundPose Decide(const PosePrediction& prediction, TrackedImage* image, FoundPose found);
  FoundPose FindAnywhere(Utime utime);
  bool TakePlace(const PlaceWatch::Confirmed& confirmed, TrackedImage* image);

  FrontendConfig config_;
  MotionModel* motion_;
  ImageCleaner* cleaner_;
  LocalMap* map_;
  Witnesses* witnesses_;
  PlaceWatch* place_;
  CameraTrack* track_;
  PoseFinder finder_;
};

}  // namespace gw::frontend

// Tells by their features alone whether two images in a row show the same scene: it needs no map,
// so it also notices that the robot was carried away where dead reckoning leads and nothing is
// mapped.
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

// Share of the features of an image before (at a) that this one (at b) has where the motion puts
// them, of those that it puts into the image; 0 when there are none.
double ShareSeenAgain(const RectifiedCamera& camera, const FeatureFrame& before,
                      const FeatureFrame& frame, const SE3& T_CbCa);

class ViewChange {
 public:
  explicit ViewChange(const RectifiedCamera& camera) : camera_(camera) {}

  // True when this image shows nothing of the two images before, although all are rich and dead
  // reckoning saw hardly any motion between them. (Two: an infrared projector that blinks with
  // every second image makes each unlike the one before.) T_OC: its camera in the odometry frame;
  // empty without dead reckoning.
  bool Changed(Utime utime, const FeatureFrame& frame, const std::optional<SE3>& T_OC) const;

  // After every image.
  void Remember(Utime utime, const FeatureFrame& frame, const std::optional<SE3>& T_OC);

 private:
  struct Image {
    Utime utime;
    FeatureFrame frame;
    SE3 T_OC;
  };
  bool ShowsNothingOf(const Image& before, Utime utime, const FeatureFrame& frame,
                      const SE3& T_OC) const;

  RectifiedCamera camera_;
  std::optional<Image> before_, before_that_;  // rich, with dead reckoning
};

}  // namespace gw::frontend

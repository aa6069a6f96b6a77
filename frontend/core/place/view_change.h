// Tells by their features alone whether two images in a row show the same scene: it needs no map,
// so it also notices that the robot was carried away where dead reckoning leads and nothing is
// mapped.
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

// Features of an image before (at a), compared with this one (at b).
struct SeenAgain {
  int in_view = 0;   // that the motion leaves in the image
  int expected = 0;  // of those, whose place in it is known: without depth where it hardly matters
  int seen = 0;      // of those, that are there
  double share() const { return expected > 0 ? static_cast<double>(seen) / expected : 0.0; }
};
SeenAgain CountSeenAgain(const RectifiedCamera& camera, const FeatureFrame& before,
                         const FeatureFrame& frame, const SE3& T_CbCa);

class ViewChange {
 public:
  explicit ViewChange(const RectifiedCamera& camera) : camera_(camera) {}

  // True when this image shows nothing of the two images before, although all are rich and should
  // share much of their view by dead reckoning, however long ago they were taken. (Two: an infrared
  // projector that blinks with every second image makes each unlike the one before.) T_OC: its
  // camera in the odometry frame; empty without dead reckoning.
  bool Changed(const FeatureFrame& frame, const std::optional<SE3>& T_OC) const;

  // After every image.
  void Remember(const FeatureFrame& frame, const std::optional<SE3>& T_OC);

 private:
  struct Image {
    FeatureFrame frame;
    SE3 T_OC;
  };
  bool ShowsNothingOf(const Image& before, const FeatureFrame& frame, const SE3& T_OC) const;

  RectifiedCamera camera_;
  std::optional<Image> before_, before_that_;  // rich, with dead reckoning
};

}  // namespace gw::frontend

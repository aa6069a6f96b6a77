// Tells by their features alone whether images in a row show the same scene: it needs no map, so it
// also notices that the robot was carried away where dead reckoning leads and nothing is mapped,
// and that it was not where vision breaks for another reason.
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

// What an image shows of the images before.
enum class ViewVerdict {
  kUnknown,  // they have too little in common by dead reckoning, or are not rich
  kSame,     // more of the scene before, where dead reckoning says, than another scene would
  kOther,    // nothing of the two before
};

class ViewChange {
 public:
  explicit ViewChange(const RectifiedCamera& camera) : camera_(camera) {}

  // Images are compared where all are rich and should share much of their view by dead reckoning,
  // however long ago they were taken. (Two before: an infrared projector that blinks with every
  // second image makes each unlike the one before.) T_OC: camera of this image in the odometry
  // frame; empty without dead reckoning.
  ViewVerdict Compare(const FeatureFrame& frame, const std::optional<SE3>& T_OC) const;

  // After every image.
  void Remember(const FeatureFrame& frame, const std::optional<SE3>& T_OC);

 private:
  struct Image {
    FeatureFrame frame;
    SE3 T_OC;
  };
  ViewVerdict Compare(const Image& before, const FeatureFrame& frame, const SE3& T_OC) const;

  RectifiedCamera camera_;
  std::optional<Image> before_, before_that_;  // rich, with dead reckoning
};

}  // namespace gw::frontend

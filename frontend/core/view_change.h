// Whether two images in a row show the same scene, by their features alone: it needs no map, so it
// also notices that the robot was carried away where dead reckoning leads and nothing is mapped.
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/feature_frame.h"
#include "frontend/core/feature_grid.h"

namespace gw::frontend {

class ViewChange {
 public:
  explicit ViewChange(const RectifiedCamera& camera) : camera_(camera) {}

  // The next image, with its camera in the odometry frame (empty without dead reckoning). True: it
  // shows nothing of the image before, although both are rich and dead reckoning saw hardly any
  // motion between them.
  bool Observe(Utime utime, const FeatureFrame& frame, const std::optional<SE3>& T_OC);

 private:
  // Share of the features of the image before that this one has where the motion puts them.
  double ShareSeenAgain(const FeatureFrame& frame, const SE3& T_CbCa) const;

  RectifiedCamera camera_;
  bool has_before_ = false;  // a rich image, with dead reckoning
  Utime utime_;
  FeatureFrame before_;
  SE3 T_OC_;
  FeatureGrid grid_;  // of the newest image
};

}  // namespace gw::frontend

// What an image shows of the world, at one instant: without what is fixed to the camera, without
// depth that is spoilt because the eyes are not of one instant, with the depth of its own instant,
// and as a global shutter would have seen it.
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "common/vision/pyramid.h"
#include "frontend/core/features/depth_sync.h"
#include "frontend/core/features/eye_sync.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/fixed_in_image.h"
#include "frontend/core/features/view_fault.h"

namespace gw::frontend {

// The frames that it returns stay valid until its next call, or are the argument.
class ImageCleaner {
 public:
  ImageCleaner(const CameraGeometry& geometry, const Pyramid& pyramid)
      : camera_(geometry.rectified),
        eyes_(camera_),
        depth_sync_(geometry),
        fixed_(camera_, pyramid) {}

  // With every image, before its pose is sought; step: the camera's motion since the image before,
  // by dead reckoning, empty where that does not tell.
  const FeatureFrame* LeaveOutFixed(Utime utime, const FeatureFrame& seen,
                                    const std::optional<CameraStep>& step);

  // Judges whether the eyes are of one instant. T_ab: the camera's motion over the time `dt` before
  // the image, > 0, however known.
  void JudgeEyes(const FeatureFrame& seen, const SE3& T_ab, DurationUs dt);

  // Judges whether depth images are of the instant of the grey ones.
  DepthSync& depth_sync() { return depth_sync_; }

  // The image that LeaveOutFixed gave, corrected for the motion T_ab; may be tried with others.
  const FeatureFrame* Correct(const FeatureFrame* of_world, const SE3& T_ab, DurationUs dt);

  // A feature of which nothing is known yet is likely to be fixed to the camera.
  bool fixed_prevails() const { return fixed_.Prevails(); }
  // When what is fixed was first seen. Precondition: fixed_prevails().
  Utime fixed_since() const { return fixed_.since(); }
  // Depth is of another image's moment rather than of its own.
  ViewFault depth_fault() const;
  // The eyes are not of one instant, whether it matters or not.
  bool eyes_apart() const { return eyes_.Lateness() != 0; }
  // The eyes of the newest image that was judged are not of one instant, and it matters.
  bool depth_spoilt() const { return depth_spoilt_; }

 private:
  RectifiedCamera camera_;
  EyeSync eyes_;
  DepthSync depth_sync_;
  FixedInImage fixed_;
  FeatureFrame of_world_;   // of the newest image, without what is fixed to the camera
  FeatureFrame corrected_;  // ... its rolling shutter undone, without depth that is spoilt
  bool depth_spoilt_ = false;
};

}  // namespace gw::frontend

// Are the two images of a stereo pair of one instant? When the right one is late by tau, everything
// in it has moved on: a partner lies tau v' px below the row of its feature, v' being the speed of
// the feature in the image. Disparities are then off by tau u', which nothing else tells: a map
// made from them is bent, consistent, and looks healthy.
//
// Row offsets of rectified eyes are noise otherwise, but for what rectification leaves,
//
//   dv = tau v' + c_0 + c_1 (v - c_y) / f_y + c_2 (u - c_x) / f_x + noise
//
// whose four unknowns are estimated by robust least squares over the last seconds. Motion sets the
// first apart from the others.
#pragma once

#include <Eigen/Core>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

class EyeSync {
 public:
  explicit EyeSync(const RectifiedCamera& camera) : camera_(camera) {}

  // With every image; T_ab: the camera's motion over the time `dt` before it, > 0, however known.
  void Observe(const FeatureFrame& frame, const SE3& T_ab, DurationUs dt);

  // By how much the right image is late, s; negative: early. 0 until it is certain (5 sigma).
  double Lateness() const;

  // True where the lateness moves disparities of this image by more than a pixel (RMS), at this
  // speed of the camera.
  bool SpoilsDepth(const FeatureFrame& frame, const SE3& T_ab, DurationUs dt) const;

 private:
  using Vector4 = Eigen::Vector4d;

  Eigen::Matrix4d WithPrior() const;
  // Speed of a feature in the image, px/s; twist of the camera in its axes, 1/s.
  Eigen::Vector2d SpeedOf(const Feature& f, const Vector6d& twist) const;

  RectifiedCamera camera_;
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Zero();
  Vector4 vector_ = Vector4::Zero();
  double squares_ = 0, count_ = 0;  // of residuals, clipped
};

}  // namespace gw::frontend

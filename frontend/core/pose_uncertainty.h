// How far the pose of the tracker may be off: its covariance, kept honest whatever the weights.
//
// The weights of Good Weights (alpha) decide where the pose goes; they are no statement about
// noise, so the inverse Hessian is no covariance. Here the error itself is followed through the
// estimator:
//
//   predicted   x- = A x + G c + w          A = Ad(inv(T_ab)); w, c: what the DR filter says of its
//                                           white noise and of its constant twist error c
//   estimated   x+ = (I - K) x- + K v       K = inv(H_v + H_p) H_v, the pull of vision against the
//                                           prior in this image; v: error of the visual estimate
//
// K = 0 while blind: then x- is exactly the growth that the filter reports, also over minutes,
// because the correlation of x and c is kept. Tangents: camera, right perturbation; c: body twist.
#pragma once

#include "common/contract/dr_history.h"
#include "common/core/se3.h"

namespace gw::frontend {

// Covariance of a pose that vision found with this information, for known landmarks.
Matrix6d VisionCovariance(const Matrix6d& vision_information);

class PoseUncertainty {
 public:
  // The pose has this covariance, and no error in common with DR.
  void Reset(const Matrix6d& cov);

  // The camera moved by T_ab; noise in camera axes (lever from the body's twist to the camera).
  void Predict(const SE3& T_ab, const DrNoise& noise);

  // Vision entered with this information of the right perturbation, against a prior with this one
  // (zero: vision alone). Call after Predict.
  void Update(const Matrix6d& vision_information, const Matrix6d& prior_information);

  const Matrix6d& cov() const { return cov_; }

 private:
  Matrix6d cov_ = Matrix6d::Zero();
  Matrix6d cross_ = Matrix6d::Zero();  // E[x c^T]
};

}  // namespace gw::frontend

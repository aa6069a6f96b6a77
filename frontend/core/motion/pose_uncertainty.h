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
// Images in a row see the same landmarks, so v changes slowly: K v = B n, with B B^T its covariance
// and n a first-order Gauss-Markov process of unit variance. Where vision pulls weakly, for many
// images, it does not average out as independent errors would.
//
// K = 0 while blind: then x- is exactly the growth that the filter reports, also over minutes,
// because the correlation of x and c is kept, as far as c of now is that of before (DrNoise::kept).
// Tangents: camera, right perturbation.
//
// The motion between two images has the covariance of x_b - Ad(inv(T_ab)) x_a. Errors of poses a
// second apart have much in common, unless vision placed each of them: E[x_b x_a^T] is followed
// too. Where the map moved between them (local BA, a loop), so did the pose: that shift was an
// error of one of the two, and s s^T is added to the covariance of the motion.
#pragma once

#include <deque>
#include <optional>

#include "common/core/se3.h"
#include "common/good_weights/dr_history.h"

namespace gw::frontend {

class PoseUncertainty {
 public:
  static constexpr double kVisionMemory = 0.5;  // s, of v: how long landmarks stay in use

  // The pose has this covariance, and no error in common with DR or with poses before.
  void Reset(const Matrix6d& cov);

  // The camera moved by T_ab in this time; noise in camera axes (lever from the body's twist to the
  // camera).
  void Predict(const SE3& T_ab, const DrNoise& noise, DurationUs time);

  // Vision entered with this information of the right perturbation, against a prior with this one
  // (zero: vision alone). Call after Predict.
  void Update(const Matrix6d& vision_information, const Matrix6d& prior_information);

  // The map moved, and the pose with it by this right perturbation.
  void Shift(const Vector6d& shift);

  const Matrix6d& cov() const { return cov_; }

  struct Motion {
    DurationUs length;
    Matrix6d cov;  // right perturbation of T_CaCb
  };
  // The pose is now final and that of an image. Returns the covariance of the motion since the
  // image that lies `span` before it, to kSpanTolerance; empty when there is none.
  std::optional<Motion> Remember(Utime utime, const SE3& T_WC, DurationUs span);

 private:
  static constexpr DurationUs kSpanTolerance = Milliseconds(50);
  struct Past {
    Utime utime;
    SE3 T_WC;
    Matrix6d cov;
    DrLever cross;         // E[x_a c^T]
    Matrix6d with_now;     // E[x x_a^T]
    Matrix6d with_vision;  // E[x_a n^T], n of now
    Vector6d shift;        // s: how far the map moved since then, in camera axes of now
  };

  Matrix6d cov_ = Matrix6d::Zero();
  DrLever cross_ = DrLever::Zero();          // E[x c^T]
  Matrix6d with_vision_ = Matrix6d::Zero();  // E[x n^T]
  std::deque<Past> past_;                    // images of the last span
};

}  // namespace gw::frontend

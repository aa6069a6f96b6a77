// A pose that vision found after it was broken (a blind span, a push, a carry, a restart): is it to
// be believed? Few matches can agree by chance.
//
//   where the robot may be        many inliers are believed at once; fewer when the next image says
//                                 the same, but not while the place is in doubt
//   elsewhere, or nobody knows    dead reckoning must be wrong, or is not there: many inliers in
//   where it may be               several images in a row
#pragma once

#include <optional>

#include "common/core/chi_square.h"
#include "common/core/se3.h"

namespace gw::frontend {

// The pose may be anywhere in the map: what is published until it is known where. Variances of
// (10 m)^2 and (1 rad)^2.
Matrix6d CovarianceOfNoIdea();

// Squared Mahalanobis distance of two poses within kChi2Six99.
bool PosesAgree(const SE3& T_expected, const SE3& T_found, const Matrix6d& cov);

class Recovery {
 public:
  static constexpr int kConvincingInliers = 60;
  static constexpr int kContradictingImages = 5;

  struct Finding {
    SE3 T_WC;
    Matrix6d cov;  // of what vision says
    int num_inliers = 0;
    SE3 T_ab;  // motion of the camera since the image before, and its covariance
    Matrix6d cov_ab;
  };
  // Where the camera may be, without vision.
  struct Expectation {
    SE3 T_WC;
    Matrix6d cov;
    bool in_doubt = false;  // something contradicts it
  };
  enum class Verdict {
    kWait,        // not yet
    kAsExpected,  // believed
    kElsewhere,   // believed; what was expected is wrong
  };

  // One image. expected: empty when nobody knows where the camera is.
  Verdict Judge(const Finding& found, const std::optional<Expectation>& expected);

  // Vision found nothing in an image, or carries the pose.
  void Reset() { before_.reset(); }

 private:
  struct Streak {
    SE3 T_WC;
    Matrix6d cov;
    int images = 1;  // in a row that agree
  };
  std::optional<Streak> before_;
};

}  // namespace gw::frontend

// Motion-only bundle adjustment: the pose of one image against fixed landmarks, with room for a
// prior on the pose (Du, Peng, Vela, "Good Weights", arXiv 2509.22910, equation 6).
//
//   min over T_WC:  sum_i rho(|r_i(T_WC, p_i)|^2) + |Log(inv(T_prior) T_WC)|^2_information
//
// r: common/vision/reprojection.h; rho: Huber loss, pixel and depth apart; damped Gauss-Newton with
// analytic Jacobians; outliers are set aside by chi-square between rounds. 6 x 6, no heap in the
// inner loop.
#pragma once

#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/vision/reprojection.h"

namespace gw {

// A landmark, and where the image shows it.
struct LandmarkObservation {
  Eigen::Vector3d p_W;
  PixelObservation pixel;
};

struct PosePrior {
  SE3 T_WC;
  Matrix6d information = Matrix6d::Zero();  // of the right perturbation
};

struct PoseEstimate {
  SE3 T_WC;
  std::vector<uint8_t> inlier;  // one per observation
  int num_inliers = 0;
  Matrix6d vision_information = Matrix6d::Zero();  // of the inliers at the solution
  Matrix6d prior_information = Matrix6d::Zero();   // as given, at the solution
};

// Without observations the result is exactly the prior (or T_WC_start without one).
PoseEstimate OptimizePose(const RectifiedCamera& camera, const SE3& T_WC_start,
                          const std::vector<LandmarkObservation>& observations,
                          const std::optional<PosePrior>& prior);

}  // namespace gw

// Motion-only bundle adjustment: the pose of one image against fixed landmarks, with room for a
// prior on the pose (paper eq. 5).
//
//   min over T_WC:  sum_i rho( |z_i - h(T_WC, p_i)|^2 / sigma_i^2 )  +  | Log(inv(T_prior) T_WC)
//   |^2_info
//
// z = (u, v, u_right), or (u, v) without depth; Huber loss; damped Gauss-Newton with analytic
// Jacobians; outliers are set aside by chi-square between rounds. 6 x 6, no heap in the inner loop.
#pragma once

#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"

namespace gw {

struct PoseObservation {
  Eigen::Vector3d p_W;  // landmark
  double u = 0, v = 0;  // px
  double u_right = 0;   // px; may be negative at the image border
  bool has_right = false;
  double inverse_sigma2 = 1;  // 1 / px^2
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
  double mean_chi2 = 0;  // of the inliers, per degree of freedom; about 1 when sigmas are honest
};

// 95 % quantiles of chi-square with 1, 2 and 3 degrees of freedom.
inline constexpr double kChi2Depth = 3.841;
inline constexpr double kChi2Mono = 5.991;
inline constexpr double kChi2Stereo = 7.815;

// Residual and Jacobian of one observation; exposed for its test. Rows: u, v[, u_right]. Returns
// the number of rows (2 or 3), or 0 when the point is not in front of the camera.
int ReprojectionResidual(const RectifiedCamera& camera, const SE3& T_CW,
                         const PoseObservation& observation, Eigen::Vector3d* residual,
                         Eigen::Matrix<double, 3, 6>* jacobian);

// Without observations the result is exactly the prior (or T_WC_start without one).
PoseEstimate OptimizePose(const RectifiedCamera& camera, const SE3& T_WC_start,
                          const std::vector<PoseObservation>& observations,
                          const std::optional<PosePrior>& prior);

}  // namespace gw

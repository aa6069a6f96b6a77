// The law of Good Weights: how much the information of dead reckoning (DR) counts for a given
// quality of vision (docs/method.md, section 3.1).
//
//   alpha(Q) = alpha_min (alpha_max / alpha_min)^(1 - Q)             (equation 3)
//   information of the DR prior = alpha(Q) inv(Sigma_d0)             (equation 2)
//
// Equations of Du, Peng, Vela, "Good Weights", arXiv 2509.22910. Front-end, local and global bundle
// adjustment and the pose graph take alpha from here, and nowhere else.
#pragma once

#include "common/config/dr_weight_config.h"

namespace gw {

// Exactly alpha_min at q >= 1 and alpha_max at q <= 0.
double InformationScale(double q, const DrWeightConfig& config);

// Far landmarks tell how the camera turned, only close ones (with depth) how far it went. The
// translation of a prior therefore follows the quality that close features alone give
// (docs/adr/0007-what-counts-as-tracked.md), which is never above the quality of all.
struct DrScale {
  double translation = 0;  // 0: dead reckoning does not enter
  double rotation = 0;
};

// The prior of one image; with the paper's law one scale for all axes. Zero in variants without DR
// in pose estimation.
DrScale PriorScale(Variant variant, double q, double q_close, const DrWeightConfig& config);

// The edge between two keyframes that follow each other, of quality q. Zero in variants without DR
// in local bundle adjustment.
double EdgeScale(Variant variant, double q, const DrWeightConfig& config);

}  // namespace gw

// Good Weights: turns the health of visual tracking into the scale of the dead-reckoning (DR)
// prior.
//
//   Q     = w * clip(N_det / N_det_ref) + (1 - w) * clip(N_trk / N_trk_ref)          (paper eq. 4)
//   alpha = alpha_min * (alpha_max / alpha_min)^(1 - Q)                              (paper eq. 3)
//   inv(Sigma_d) = alpha * inv(Sigma_d0)                                             (paper eq. 2)
//
// Vision leads when it is healthy (alpha_min hardly counts), DR carries when it is not. Called once
// per image by the tracker; no covariance of single features is touched.
#pragma once

#include "common/config/frontend_config.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::frontend {

// Counts of one image.
struct TrackingHealth {
  int num_detected = 0;  // features found in the image
  int num_tracked = 0;   // of them matched to the local map in the first stage
};

// Q in [0, 1].
double Quality(const TrackingHealth& health, const DrWeightConfig& config);

// Scale of the DR information; q is clamped to [0, 1]. Exactly alpha_min at 1 and alpha_max at 0.
double InformationScale(double q, const DrWeightConfig& config);

// The scale that a variant uses: none and da -> 0, fixed -> its constant, switch -> 0 or a scale
// that leaves vision no say (`kDrAlone`), all others InformationScale.
//
// Far features tell how the camera turned, only close ones (with depth) how far it went. The
// translation of the prior is therefore scaled by the quality that the close features alone give
// (docs/adr/0007-what-counts-as-tracked.md); it is never above the quality of all.
struct DrScale {
  double translation = 0;
  double rotation = 0;
};
DrScale VariantScale(Variant variant, double q, double q_close, const DrWeightConfig& config);
inline constexpr double kDrAlone = 1e12;

// Sigma_d of an interval: nominal noise grows with the frame periods (1/30 s) spanned; the filter's
// own covariance is used where it is larger, axis by axis (method.md section 2).
Matrix6d DrCovariance(DurationUs interval, const Matrix6d& filter_cov,
                      const DrWeightConfig& config);

}  // namespace gw::frontend

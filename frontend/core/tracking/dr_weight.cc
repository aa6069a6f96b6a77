#include "frontend/core/tracking/dr_weight.h"

#include <algorithm>
#include <cmath>

namespace gw::frontend {

double Quality(const TrackingHealth& health, const DrWeightConfig& config) {
  const double detected = std::clamp(health.num_detected / config.n_det_ref, 0.0, 1.0);
  const double tracked = std::clamp(health.num_tracked / config.n_trk_ref, 0.0, 1.0);
  return config.omega_det * detected + (1.0 - config.omega_det) * tracked;
}

double InformationScale(double q, const DrWeightConfig& config) {
  if (q >= 1.0) return config.alpha_min;
  if (q <= 0.0) return config.alpha_max;
  return config.alpha_min * std::pow(config.alpha_max / config.alpha_min, 1.0 - q);
}

DrScale VariantScale(Variant variant, double q, double q_close, const DrWeightConfig& config) {
  switch (variant) {
    case Variant::kNone:
    case Variant::kDa:
      return {0.0, 0.0};
    case Variant::kFixed:
      return {config.fixed_alpha, config.fixed_alpha};
    case Variant::kSwitch: {
      const double scale = q < config.switch_q ? kDrAlone : 0.0;
      return {scale, scale};
    }
    case Variant::kPe:
    case Variant::kLba:
    case Variant::kFull:
      break;
  }
  return {InformationScale(q_close, config), InformationScale(q, config)};
}

Matrix6d DrCovariance(DurationUs interval, const Matrix6d& filter_cov,
                      const DrWeightConfig& config) {
  const double frames = std::max(interval.seconds() * 30.0, 1e-3);
  const double sigma_r = config.sigma_rot_deg_per_frame * M_PI / 180.0;
  const double var_t = config.sigma_trans_m_per_frame * config.sigma_trans_m_per_frame * frames;
  const double var_r = sigma_r * sigma_r * frames;
  // Raising the diagonal of a covariance keeps it positive definite.
  Matrix6d out = filter_cov;
  for (int i = 0; i < 6; ++i) out(i, i) = std::max(out(i, i), i < 3 ? var_t : var_r);
  return out;
}

}  // namespace gw::frontend

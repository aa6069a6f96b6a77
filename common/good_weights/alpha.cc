#include "common/good_weights/alpha.h"

#include <cmath>

namespace gw {
namespace {

// alpha of the variant where it uses DR at all.
double ScaleOf(Variant variant, double q, const DrWeightConfig& config) {
  switch (variant) {
    case Variant::kFixed:
      return config.fixed_alpha;
    case Variant::kSwitch:
      return q < config.switch_q ? config.alpha_max : 0.0;
    default:
      return InformationScale(q, config);
  }
}

}  // namespace

double InformationScale(double q, const DrWeightConfig& config) {
  if (q >= 1.0) return config.alpha_min;
  if (q <= 0.0) return config.alpha_max;
  return config.alpha_min * std::pow(config.alpha_max / config.alpha_min, 1.0 - q);
}

DrScale PriorScale(Variant variant, double q, double q_close, const DrWeightConfig& config) {
  if (!DrInPoseEstimation(variant)) return {};
  // The paper and the baselines know one quality only.
  const bool two = AdaptsAlpha(variant) && config.Departs(Departure::kTwoAlphas);
  const double q_translation = two ? q_close : q;
  return {ScaleOf(variant, q_translation, config), ScaleOf(variant, q, config)};
}

double EdgeScale(Variant variant, double q, const DrWeightConfig& config) {
  return DrInLocalBa(variant) ? ScaleOf(variant, q, config) : 0.0;
}

}  // namespace gw

#include "frontend/core/motion/scale_witness.h"

#include <algorithm>

#include "common/core/format.h"

namespace gw::frontend {
namespace {

// The filter does not know that the scale of an accelerometer may be off itself: the D435i's comes
// uncalibrated (Intel RealSense documentation), that is by a per cent or so.
constexpr double kSensitivity = 0.01;

}  // namespace

std::string Describe(const LengthFault& fault) {
  if (!fault.found()) return "";
  return "lengths that the camera tells are " + FormatFixed(fault.too_long, 3) +
         " times too long, as wheels and accelerometer agree: multiply the baseline (T_C0C1) or "
         "depth_unit_m by " +
         FormatFixed(1 / fault.too_long, 3) + " and begin a new map" +
         (fault.corrected ? "; until then it is taken out" : "");
}

void ScaleWitness::Observe(const DrState& told) {
  if (told.reset_counter != reset_counter_) *this = ScaleWitness();
  reset_counter_ = told.reset_counter;
  scale_ = told.wheel_scale;
  sigma_ = told.way_scale_sigma;
  prior_sigma_ = std::max(prior_sigma_, sigma_);
}

double ScaleWitness::LogOddsForDr(double factor) const {
  if (!(sigma_ > 0)) return 0;
  // The posterior scale is the mean of the accelerometer's and the prior one, which is 1.
  const double prior_information = 1 / (prior_sigma_ * prior_sigma_);
  const double information = 1 / (sigma_ * sigma_) - prior_information;
  if (!(information > 0)) return 0;
  const double measured = scale_ + (scale_ - 1) * prior_information / information;
  const double variance = 1 / information + kSensitivity * kSensitivity;
  const auto misfit = [&](double scale) {
    return (measured - scale) * (measured - scale) / variance;
  };
  return 0.5 * (misfit(scale_ * factor) - misfit(scale_));
}

}  // namespace gw::frontend

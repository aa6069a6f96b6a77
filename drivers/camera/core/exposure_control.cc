#include "drivers/camera/core/exposure_control.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace gw::camera {
namespace {

constexpr double kDeadBand = 0.1;  // relative error of the brightness below which nothing changes
constexpr double kMaxStep = 2;     // the largest factor by which one step changes the exposure
constexpr double kDamping = 0.7;   // share of the logarithmic error that one step corrects

}  // namespace

ExposureControl::ExposureControl(const ExposureLimits& limits)
    : limits_(limits),
      setting_{std::max(limits.max_exposure_us / 2, limits.min_exposure_us), limits.min_gain},
      wanted_us_(setting_.exposure_us) {
  GW_CHECK(limits.min_exposure_us > 0 && limits.min_exposure_us <= limits.max_exposure_us);
  GW_CHECK(limits.min_gain > 0 && limits.min_gain <= limits.max_gain);
}

std::optional<ExposureSetting> ExposureControl::Observe(double mean_grey) {
  if (++frames_ < kFramesPerStep) return std::nullopt;
  frames_ = 0;
  const double error = kTargetGrey / std::max(mean_grey, 1.0);
  if (std::abs(error - 1) < kDeadBand) return std::nullopt;
  const double max_us =
      static_cast<double>(limits_.max_exposure_us) * limits_.max_gain / limits_.min_gain;
  wanted_us_ =
      std::clamp(wanted_us_ * std::pow(std::clamp(error, 1 / kMaxStep, kMaxStep), kDamping),
                 static_cast<double>(limits_.min_exposure_us), max_us);
  ExposureSetting next;
  next.exposure_us = static_cast<uint32_t>(
      std::min(std::round(wanted_us_), static_cast<double>(limits_.max_exposure_us)));
  next.gain = std::clamp(
      static_cast<int32_t>(std::lround(limits_.min_gain * wanted_us_ / next.exposure_us)),
      limits_.min_gain, limits_.max_gain);
  if (next == setting_) return std::nullopt;
  setting_ = next;
  return next;
}

}  // namespace gw::camera

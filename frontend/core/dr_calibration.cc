#include "frontend/core/dr_calibration.h"

#include <algorithm>

namespace gw::frontend {
namespace {

constexpr DurationUs kWindow = Milliseconds(1000);
// Noise of the comparison over a window: vision at both its ends, and DR within it but for its
// scale (measured on the simulated scenarios, healthy spans).
constexpr double kHeadingSigma = 0.002;  // rad
constexpr double kWaySigma = 0.008;      // m
// Scales drift with temperature and tyres: 0.1 % in 100 s.
constexpr double kVarianceRate = 1e-8;  // 1/s
constexpr double kGateSigmas = 4;
// Of a DR source that says nothing of its scales.
constexpr double kUntoldHeadingSigma = 0.01;
constexpr double kUntoldWaySigma = 0.02;
constexpr int kX = 0, kHeading = 5;  // of a twist

}  // namespace

DrCalibration::Told DrCalibration::Heading(const DrState& dr) {
  return Bounded(dr.turn_scale,
                 dr.turn_scale_sigma > 0 ? dr.turn_scale_sigma : kUntoldHeadingSigma);
}

DrCalibration::Told DrCalibration::Way(const DrState& dr) {
  return Bounded(dr.wheel_scale, dr.way_scale_sigma > 0 ? dr.way_scale_sigma : kUntoldWaySigma);
}

DrCalibration::Told DrCalibration::Bounded(double scale, double sigma) {
  return {std::clamp(scale, 0.5, 2.0), std::clamp(sigma, 1e-6, 1.0)};
}

double DrCalibration::Scale::Fused(const Told& told) const {
  const double told_information = 1 / (told.sigma * told.sigma);
  return (information * estimate + told_information * told.scale) /
         (information + told_information);
}

void DrCalibration::Scale::Update(double dr, double measured, double sigma, const Told& told) {
  const double sensor = dr / told.scale;
  const double variance = 1 / (information + 1 / (told.sigma * told.sigma));
  const double innovation = measured - Fused(told) * sensor;
  const double innovation_variance = sensor * sensor * variance + sigma * sigma;
  if (innovation * innovation > kGateSigmas * kGateSigmas * innovation_variance) return;
  information += sensor * sensor / (sigma * sigma);
  if (information == 0) return;
  estimate += sensor / (sigma * sigma * information) * (measured - estimate * sensor);
}

void DrCalibration::Scale::Forget(DurationUs time) {
  information /= 1 + information * kVarianceRate * time.seconds();
}

double DrCalibration::Scale::DoubtLeft(double told_sigma) const {
  return 1 / (1 + told_sigma * told_sigma * information);
}

SE3 DrCalibration::Corrected(const SE3& T_BaBb, const DrState& dr) const {
  const Told way = Way(dr);
  const Told heading = Heading(dr);
  Vector6d twist = T_BaBb.Log();
  twist[kX] *= way_.Fused(way) / way.scale;
  twist[kHeading] *= heading_.Fused(heading) / heading.scale;
  return SE3::Exp(twist);
}

void DrCalibration::Limit(DrNoise* noise, const DrState& dr) const {
  noise->coherent(kWayScale, kWayScale) *= way_.DoubtLeft(Way(dr).sigma);
  noise->coherent(kTurnScale, kTurnScale) *= heading_.DoubtLeft(Heading(dr).sigma);
}

void DrCalibration::Observe(const SE3& T_BaBb_dr, const SE3& T_BaBb_vision, DurationUs interval,
                            const DrState& dr) {
  window_.dr = window_.dr * T_BaBb_dr;
  window_.vision = window_.vision * T_BaBb_vision;
  window_.length = window_.length + interval;
  if (window_.length < kWindow) return;
  const Vector6d by_dr = window_.dr.Log();
  const Vector6d by_vision = window_.vision.Log();
  for (Scale* const scale : {&heading_, &way_}) scale->Forget(window_.length);
  heading_.Update(by_dr[kHeading], by_vision[kHeading], kHeadingSigma, Heading(dr));
  way_.Update(by_dr[kX], by_vision[kX], kWaySigma, Way(dr));
  window_ = Window();
}

}  // namespace gw::frontend

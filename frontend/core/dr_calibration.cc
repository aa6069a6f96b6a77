#include "frontend/core/dr_calibration.h"

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
constexpr int kX = 0, kHeading = 5;  // of a twist

}  // namespace

void DrCalibration::Scale::Update(double dr, double measured, double sigma) {
  const double innovation = measured - (1 + error) * dr;
  const double innovation_variance = dr * dr * variance + sigma * sigma;
  if (innovation * innovation > kGateSigmas * kGateSigmas * innovation_variance) return;
  const double gain = variance * dr / innovation_variance;
  error += gain * innovation;
  variance *= 1 - gain * dr;
}

SE3 DrCalibration::Corrected(const SE3& T_BaBb) const {
  Vector6d twist = T_BaBb.Log();
  twist[kX] *= way_scale();
  twist[kHeading] *= heading_scale();
  return SE3::Exp(twist);
}

void DrCalibration::Observe(const SE3& T_BaBb_dr, const SE3& T_BaBb_vision, DurationUs interval) {
  window_.dr = window_.dr * T_BaBb_dr;
  window_.vision = window_.vision * T_BaBb_vision;
  window_.length = window_.length + interval;
  if (window_.length < kWindow) return;
  const Vector6d dr = window_.dr.Log();
  const Vector6d vision = window_.vision.Log();
  for (Scale* const scale : {&heading_, &way_}) {
    scale->variance += kVarianceRate * window_.length.seconds();
  }
  heading_.Update(dr[kHeading], vision[kHeading], kHeadingSigma);
  way_.Update(dr[kX], vision[kX], kWaySigma);
  window_ = Window();
}

}  // namespace gw::frontend

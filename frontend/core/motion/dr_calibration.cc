#include "frontend/core/motion/dr_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace gw::frontend {
namespace {

constexpr DurationUs kWindow = Milliseconds(1000);
// Noise of the comparison over a window: vision at both its ends, and DR within it but for its
// scale (measured on the simulated scenarios, healthy spans).
constexpr double kHeadingSigma = 0.002;  // rad
constexpr double kWaySigma = 0.008;      // m
// Scales drift with temperature and tyres: 0.1 % in 100 s.
constexpr double kVarianceRate = 1e-8;  // 1/s
// The bias of a gyro drifts with its temperature: 0.02 deg/s in 100 s.
constexpr double kBiasVarianceRate = 1.2e-9;  // (rad/s)^2/s
constexpr double kGateSigmas = 4;
constexpr double kTurnSigmas = 3;
// Doubt of the scales of a DR source that says nothing of them.
constexpr double kUntoldHeadingSigma = 0.01;
constexpr double kUntoldWaySigma = 0.02;
// A straight: long, so that the noise of vision counts little, and straight, so that an error of
// the way does not pass for one beside it.
constexpr double kShortestStraight = 0.5;  // m
constexpr double kLongestStraight = 1.5;   // m
constexpr double kStraightTurn = 0.1;      // rad
// Noise of the comparison over a straight (measured as above, in young maps), and how well a camera
// is mounted: beside by eye, its pitch is told by gravity too.
constexpr double kSidewaysSigma = 0.005;             // m
constexpr double kUpwardsSigma = 0.010;              // m
constexpr double kYawSigma = 0.01;                   // rad
constexpr double kPitchSigma = 0.005;                // rad
constexpr int kX = 0, kY = 1, kZ = 2, kHeading = 5;  // of a twist

}  // namespace

DrCalibration::DrCalibration(const Eigen::Vector3d& up_I)
    : up_I_(up_I), sideways_{0, kYawSigma * kYawSigma}, upwards_{0, kPitchSigma * kPitchSigma} {}

DrCalibration::ToldTurn DrCalibration::Heading(const DrState& dr) const {
  const Told scale =
      Bounded(dr.turn_scale, dr.turn_scale_sigma > 0 ? dr.turn_scale_sigma : kUntoldHeadingSigma);
  // Without a gyro, or a word of how well it is known, there is no bias to find.
  const double variance = dr.imu_alive ? dr.cov_twist_coherent(kHeading, kHeading) : 0;
  return {{scale.scale, up_I_.dot(dr.gyro_bias_rad_s)},
          {scale.sigma, std::clamp(std::sqrt(std::max(0.0, variance)), 1e-6, 0.1)}};
}

DrCalibration::Told DrCalibration::Way(const DrState& dr) {
  return Bounded(dr.wheel_scale, dr.way_scale_sigma > 0 ? dr.way_scale_sigma : kUntoldWaySigma);
}

DrCalibration::Told DrCalibration::Bounded(double scale, double sigma) {
  return {std::clamp(scale, 0.5, 2.0), std::clamp(sigma, 1e-6, 1.0)};
}

double DrCalibration::Scale::Fused(const Told& told) const {
  const double told_information = 1 / (told.sigma * told.sigma);
  return (weighted + told_information * told.scale) / (information + told_information);
}

void DrCalibration::Scale::Update(double dr, double measured, double sigma, const Told& told) {
  const double sensor = dr / told.scale;
  const double variance = 1 / (information + 1 / (told.sigma * told.sigma));
  const double innovation = measured - Fused(told) * sensor;
  const double innovation_variance = sensor * sensor * variance + sigma * sigma;
  if (innovation * innovation > kGateSigmas * kGateSigmas * innovation_variance) return;
  information += sensor * sensor / (sigma * sigma);
  weighted += sensor * measured / (sigma * sigma);
}

void DrCalibration::Scale::Forget(DurationUs time) {
  const double kept = 1 / (1 + information * kVarianceRate * time.seconds());
  information *= kept;
  weighted *= kept;
}

double DrCalibration::Scale::DoubtLeft(double told_sigma) const {
  return 1 / (1 + told_sigma * told_sigma * information);
}

Eigen::Matrix2d DrCalibration::Turn::Covariance(const ToldTurn& told) const {
  Eigen::Matrix2d total = information;
  total.diagonal() += told.sigma.cwiseAbs2().cwiseInverse();
  return total.ldlt().solve(Eigen::Matrix2d::Identity());
}

Eigen::Vector2d DrCalibration::Turn::Fused(const ToldTurn& told) const {
  const Eigen::Vector2d of_dr = told.value.cwiseQuotient(told.sigma.cwiseAbs2());
  return Covariance(told) * (weighted + of_dr);
}

// A turn that is no larger than its own noise tells nothing of its scale: least squares would take
// the noise for turns that vision does not see, and the scale for zero.
void DrCalibration::Turn::Update(double sensed, double sensed_variance, double measured,
                                 DurationUs length, const ToldTurn& told) {
  const Eigen::Vector2d fused = Fused(told);
  const bool turns = sensed * sensed > kTurnSigmas * kTurnSigmas * sensed_variance;
  const Eigen::Vector2d tells(turns ? sensed : 0, -length.seconds());
  if (!turns) measured -= fused[0] * sensed;
  const double innovation = measured - tells.dot(fused);
  const double variance = kHeadingSigma * kHeadingSigma + fused[0] * fused[0] * sensed_variance;
  const double innovation_variance = tells.dot(Covariance(told) * tells) + variance;
  if (innovation * innovation > kGateSigmas * kGateSigmas * innovation_variance) return;
  information += tells * tells.transpose() / variance;
  weighted += tells * measured / variance;
}

void DrCalibration::Turn::Forget(DurationUs time) {
  const double faster =
      std::max(information(0, 0) * kVarianceRate, information(1, 1) * kBiasVarianceRate);
  const double kept = 1 / (1 + faster * time.seconds());
  information *= kept;
  weighted *= kept;
}

void DrCalibration::Direction::Update(double way, double beside, double sigma) {
  const double innovation = beside - estimate * way;
  const double innovation_variance = way * way * variance + sigma * sigma;
  if (innovation * innovation > kGateSigmas * kGateSigmas * innovation_variance) return;
  const double gain = variance * way / innovation_variance;
  estimate += gain * innovation;
  variance *= 1 - gain * way;
}

void DrCalibration::Window::Append(const SE3& T_dr, const SE3& T_vision, DurationUs interval) {
  dr = dr * T_dr;
  vision = vision * T_vision;
  length = length + interval;
}

SE3 DrCalibration::Corrected(const SE3& T_BaBb, DurationUs interval, const DrState& dr) const {
  const Told way = Way(dr);
  const ToldTurn told = Heading(dr);
  const Eigen::Vector2d turn = heading_.Fused(told);
  Vector6d twist = T_BaBb.Log();
  twist[kX] *= way_.Fused(way) / way.scale;
  const double sensed = twist[kHeading] / told.value[0] + told.value[1] * interval.seconds();
  twist[kHeading] = turn[0] * sensed - turn[1] * interval.seconds();
  twist[kY] += sideways_.estimate * twist[kX];
  twist[kZ] += upwards_.estimate * twist[kX];
  return SE3::Exp(twist);
}

void DrCalibration::Limit(DrNoise* noise, const DrState& dr) const {
  noise->coherent(kWayScale, kWayScale) *= way_.DoubtLeft(Way(dr).sigma);
  const ToldTurn told = Heading(dr);
  const Eigen::Vector2d left =
      heading_.Covariance(told).diagonal().cwiseQuotient(told.sigma.cwiseAbs2());
  noise->coherent(kTurnScale, kTurnScale) *= left[0];
  noise->coherent.row(kHeading) *= std::sqrt(left[1]);
  noise->coherent.col(kHeading) *= std::sqrt(left[1]);
}

void DrCalibration::Observe(const SE3& T_BaBb_dr, const SE3& T_BaBb_vision, DurationUs interval,
                            const DrState& dr, double turn_variance) {
  const ToldTurn told = Heading(dr);
  window_.Append(T_BaBb_dr, T_BaBb_vision, interval);
  window_.bias_turn += told.value[1] * interval.seconds();
  window_.turn_variance += turn_variance;
  // A filter that stands holds its heading, whatever it thinks of the bias.
  if (dr.stationary) window_ = Window();
  if (window_.length >= kWindow) {
    const Vector6d by_dr = window_.dr.Log();
    const Vector6d by_vision = window_.vision.Log();
    heading_.Forget(window_.length);
    way_.Forget(window_.length);
    heading_.Update(by_dr[kHeading] / told.value[0] + window_.bias_turn, window_.turn_variance,
                    by_vision[kHeading], window_.length, told);
    way_.Update(by_dr[kX], by_vision[kX], kWaySigma, Way(dr));
    window_ = Window();
  }
  straight_.Append(T_BaBb_dr, T_BaBb_vision, interval);
  const Vector6d by_dr = straight_.dr.Log();
  const double way = std::abs(by_dr[kX]);
  if (way < kLongestStraight && std::abs(by_dr[kHeading]) < kStraightTurn) return;
  if (way >= kShortestStraight) {
    const Vector6d beside = straight_.vision.Log() - by_dr;
    sideways_.Update(by_dr[kX], beside[kY], kSidewaysSigma);
    upwards_.Update(by_dr[kX], beside[kZ], kUpwardsSigma);
  }
  straight_ = Window();
}

}  // namespace gw::frontend

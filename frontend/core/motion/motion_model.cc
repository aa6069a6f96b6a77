#include "frontend/core/motion/motion_model.h"

#include <cmath>

#include "common/good_weights/camera_motion.h"
#include "common/good_weights/covariance.h"

namespace gw::frontend {
namespace {

constexpr DurationUs kMaxCoasting = Milliseconds(500);  // constant velocity is believed this long
// Spread of the real motion around constant velocity per 1/30 s (hand-held recording, 95 % of
// images).
constexpr double kCoastingSigmaRotation = 0.008;     // rad
constexpr double kCoastingSigmaTranslation = 0.010;  // m

}  // namespace

SE3 MotionModel::FirstPose(Utime utime) const {
  SE3 T_WB;
  if (DrPredicts(variant_) && !dr_.empty() && dr_.newest().gravity_aligned) {
    if (const auto T_OB = dr_.PoseAt(utime, kMaxExtrapolation)) {
      const Eigen::Matrix3d R = T_OB->rotation().toRotationMatrix();
      const double yaw = std::atan2(R(1, 0), R(0, 0));
      T_WB = SE3(ExpSO3({0, 0, -yaw}) * T_OB->rotation(), Eigen::Vector3d::Zero());
    }
  }
  return T_WB * T_BC_;
}

Motion MotionModel::Between(Utime a, Utime b) const {
  Motion out;
  const DurationUs dt = b - a;
  const bool contradicted = !trust_.trusted() && observed_ == a;
  if (DrPredicts(variant_) && !contradicted) {
    DrNoise noise_B;
    if (const auto increment = dr_.Increment(a, b, kMaxExtrapolation, &noise_B)) {
      out.T_BaBb_dr = increment->T_BaBb;
      out.T_ab = InCamera(calibration_.Corrected(out.T_BaBb_dr, dr_.newest()), T_BC_);
      calibration_.Limit(&noise_B, dr_.newest());
      out.noise = InCamera(trust_.Shown(noise_B), T_BC_);
      const Matrix6d nominal = NominalCovariance(dt, dr_weight_);
      // A source that does not tell its noise has the nominal one.
      if (out.noise.Covariance().isZero(0)) out.noise.white = nominal;
      out.weight_cov = trust_.Weighted(nominal, out.noise.Covariance());
      out.from_dr = true;
      out.slip = increment->slip;
      return out;
    }
  }
  if (b - observed_ <= kMaxCoasting) out.T_ab = SE3::Exp(velocity_ * dt.seconds());
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kCoastingSigmaTranslation),
      Eigen::Vector3d::Constant(kCoastingSigmaRotation);
  sigma *= dt.seconds() * 30.0;
  out.noise.white = sigma.cwiseAbs2().asDiagonal();
  out.weight_cov = out.noise.white;
  return out;
}

std::optional<SE3> MotionModel::OdometryPose(Utime utime) const {
  if (!DrPredicts(variant_)) return std::nullopt;
  const auto T_OB = dr_.PoseAt(utime, kMaxExtrapolation);
  if (!T_OB) return std::nullopt;
  return *T_OB * T_BC_;
}

std::optional<DrIncrement> MotionModel::Increment(Utime a, Utime b) const {
  if (!trust_.trusted()) return std::nullopt;
  DrNoise noise;
  auto increment = dr_.Increment(a, b, kMaxExtrapolation, &noise);
  if (increment) {
    increment->T_BaBb = calibration_.Corrected(increment->T_BaBb, dr_.newest());
    calibration_.Limit(&noise, dr_.newest());
    increment->cov = trust_.Shown(noise).Covariance();
  }
  return increment;
}

void MotionModel::Observe(const Seen& seen, const Motion& expected) {
  if (seen.a == observed_) velocity_ = seen.T_ab.Log() / (seen.b - seen.a).seconds();
  observed_ = seen.b;
  if (seen.healthy && calibrate_dr_ && expected.from_dr && !expected.slip) {
    calibration_.Observe(expected.T_BaBb_dr, T_BC_ * seen.T_ab * T_BC_.inverse(), seen.b - seen.a,
                         dr_.newest());
  } else {
    calibration_.Interrupt();
  }
  if (seen.sure && DrPredicts(variant_)) {
    CompareWithVision(seen);
  } else {
    window_.reset();
  }
}

void MotionModel::ObserveNothing() {
  calibration_.Interrupt();
  window_.reset();
}

void MotionModel::Restart() {
  ObserveNothing();
  velocity_.setZero();
  observed_ = {};
}

void MotionModel::MapMoved(const SE3& T_correction) {
  if (window_) window_->T_WC = T_correction * window_->T_WC;
}

void MotionModel::CompareWithVision(const Seen& seen) {
  if (window_ && seen.b - window_->begin < DrTrust::kWindow) return;
  if (window_) {
    DrNoise noise;
    const auto dr = dr_.Increment(window_->begin, seen.b, kMaxExtrapolation, &noise);
    if (dr && !dr->slip) {
      DrEvidence evidence;
      evidence.T_dr = calibration_.Corrected(dr->T_BaBb, dr_.newest());
      calibration_.Limit(&noise, dr_.newest());
      evidence.cov_dr = noise.Covariance();
      if (evidence.cov_dr.isZero(0))
        evidence.cov_dr = NominalCovariance(seen.b - window_->begin, dr_weight_);
      const SE3 T_ab = window_->T_WC.inverse() * seen.T_WC_vision;
      evidence.T_vision = T_BC_ * T_ab * T_BC_.inverse();
      const Matrix6d from_begin = T_ab.inverse().Adjoint();
      const Matrix6d cov = from_begin * window_->cov * from_begin.transpose() + seen.cov_vision;
      evidence.cov_vision = T_BC_.Adjoint() * cov * T_BC_.Adjoint().transpose();
      trust_.Judge(evidence);
    }
  }
  window_ = Window{seen.b, seen.T_WC_vision, seen.cov_vision};
}

}  // namespace gw::frontend
